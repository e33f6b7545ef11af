// What materials cost the baker, in nanoseconds a height sample (a texel, for blocks), on one core.
//
// Names: stage/scene/parameter. Scene: the north-west 2049 x 2049 samples of content/terrain/mountains.json in tiles of
// 512 cells, their middle tile.
#include <benchmark/benchmark.h>

#include <cstring>
#include <vector>

#include <stb_dxt.h>

#include "baker/maps/image.h"
#include "baker/maps/maps.h"
#include "shared/block_codes.h"
#include "support/dem.h"

namespace {

using namespace fjell;

const baker::Dem& dem() {
    static const baker::Dem made =
        baker::synthesise_text(R"({"columns": 2049, "rows": 2049, "spacing_m": 60, "seed": 1, "relief_m": 3000})");
    return made;
}

baker::MapPlan plan_of(std::uint32_t colour_log2, std::uint32_t normal_log2) {
    baker::MapPlan plan;
    plan.tree = Tree::covering(2049, 2049, 9);
    plan.spacing_m[0] = plan.spacing_m[1] = 60;
    plan.colour_log2 = colour_log2;
    plan.normal_log2 = normal_log2;
    plan.ramp = absolute(baker::default_ramp(), 0, 3050);
    return plan;
}

void per_sample(benchmark::State& state, double samples) {
    state.counters["ns_each"] = benchmark::Counter(samples * static_cast<double>(state.iterations()) * 1e-9,
                                                   benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void near_maps(benchmark::State& state, const baker::MapPlan& plan) {
    constexpr std::uint32_t tile = 5;
    const baker::Window w = heights_for_maps(plan, tile);
    std::vector<float> heights;
    for (int y = w.y; y < w.y + w.rows; ++y)
        for (int x = w.x; x < w.x + w.columns; ++x) heights.push_back(dem().at(x, y));
    const auto reader = plan.image ? plan.image->reader() : nullptr;
    for (auto _ : state)
        benchmark::DoNotOptimize(baker::near_maps(plan, tile, {heights.data(), w.columns, w}, reader.get()));
    per_sample(state, 512.0 * 512.0);
}

// One row again and again: reading costs a copy, what is measured is the filter.
class Rows final : public baker::ImageSource {
public:
    explicit Rows(int side) : row_(static_cast<std::size_t>(side) * 4, 180) {
        layers = {{side, side, {0, 0}, {side / 2048.0, side / 2048.0}}};
        for (std::size_t i = 0; i < row_.size(); ++i) row_[i] = i % 4 == 3 ? 255 : static_cast<std::uint8_t>(i / 16);
    }
    [[nodiscard]] std::unique_ptr<baker::ImageReader> reader() const override { return std::make_unique<Reader>(row_); }
    [[nodiscard]] std::string identity() const override { return {}; }

private:
    struct Reader final : baker::ImageReader {
        const std::vector<std::uint8_t>& row;
        explicit Reader(const std::vector<std::uint8_t>& from) : row(from) {}
        void read(std::size_t, const baker::Window& w, std::uint8_t* rgba) override {
            const std::size_t bytes = static_cast<std::size_t>(w.columns) * 4;
            for (int y = 0; y < w.rows; ++y, rgba += bytes) std::memcpy(rgba, row.data() + 4 * w.x, bytes);
        }
    };
    std::vector<std::uint8_t> row_;
};

void with_image(benchmark::State& state, int pixels_per_tile) {
    baker::MapPlan plan = plan_of(9, 0);
    const Rows image(4 * pixels_per_tile);
    plan.image = &image;
    near_maps(state, plan);
}

// A map's worth of slowly changing texels with some grain, as blocks see it.
const std::vector<std::uint8_t>& texels() {
    static const auto made = [] {
        std::vector<std::uint8_t> all(512 * 512);
        std::uint32_t grain = 1;
        for (std::size_t i = 0; i < all.size(); ++i)
            all[i] = static_cast<std::uint8_t>(100 + i % 512 / 8 + i / 8192 +
                                               (grain = grain * 1664525 + 1013904223) / (1u << 28));
        return all;
    }();
    return made;
}

void bc1(benchmark::State& state) {
    std::vector<std::byte> to(512 * 512 / 2);
    for (auto _ : state)
        for (std::size_t y = 0; y < 512; y += 4) {
            ColourRows rows{};
            for (std::size_t i = 0; i < 4; ++i)
                for (std::size_t c = 0; c < 3; ++c) rows.rows[i][c] = texels().data() + (y ^ (c * 128)) * 512 + i * 512;
            encode_bc1(rows, 128, to.data() + y / 4 * 1024);
        }
    per_sample(state, 512.0 * 512.0);
}

void bc5(benchmark::State& state) {
    std::vector<std::byte> to(512 * 512);
    for (auto _ : state)
        for (std::size_t y = 0; y < 512; y += 4) {
            NormalRows rows{};
            for (std::size_t i = 0; i < 4; ++i)
                for (std::size_t c = 0; c < 2; ++c) rows.rows[i][c] = texels().data() + (y ^ (c * 128)) * 512 + i * 512;
            encode_bc5(rows, 128, to.data() + y / 4 * 2048);
        }
    per_sample(state, 512.0 * 512.0);
}

// The reference: libstb's encoders on the same texels.
void stb(benchmark::State& state, bool colour) {
    std::uint8_t block[64], to[16];
    for (auto _ : state)
        for (std::size_t y = 0; y < 512; y += 4)
            for (std::size_t x = 0; x < 512; x += 4) {
                const std::size_t step = colour ? 4 : 2;
                for (std::size_t i = 0; i < 16 * step; ++i) {
                    const std::size_t c = i % step, t = i / step;
                    block[i] = c == 3 ? 255 : texels()[((y ^ (c * 128)) + t / 4) * 512 + x + t % 4];
                }
                colour ? stb_compress_dxt_block(to, block, 0, STB_DXT_NORMAL) : stb_compress_bc5_block(to, block);
                benchmark::DoNotOptimize(to);
            }
    per_sample(state, 512.0 * 512.0);
}

} // namespace

int main(int argc, char** argv) {
    const auto declare = [](const char* name, auto run) {
        benchmark::RegisterBenchmark(name, run)->Unit(benchmark::kMillisecond)->MinTime(0.3);
    };
    declare("maps/mountains-2049/normal-512", [](auto& s) { near_maps(s, plan_of(0, 9)); });
    declare("maps/mountains-2049/ramp-256", [](auto& s) { near_maps(s, plan_of(8, 0)); });
    declare("maps/mountains-2049/ramp-512", [](auto& s) { near_maps(s, plan_of(9, 0)); });
    declare("maps/mountains-2049/normal-512-ramp-256", [](auto& s) { near_maps(s, plan_of(8, 9)); });
    declare("maps/mountains-2049/image-512-of-512", [](auto& s) { with_image(s, 512); });
    declare("maps/mountains-2049/image-512-of-2048", [](auto& s) { with_image(s, 2048); });
    declare("blocks/texels-512/bc1", bc1);
    declare("blocks/texels-512/bc1-stb", [](auto& s) { stb(s, true); });
    declare("blocks/texels-512/bc5", bc5);
    declare("blocks/texels-512/bc5-stb", [](auto& s) { stb(s, false); });
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
