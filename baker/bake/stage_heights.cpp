// Stages that bring the heights in: read, fill, survey.
#include <algorithm>
#include <cmath>

#include "baker/bake/parallel.h"
#include "baker/bake/pipeline.h"
#include "baker/heights/fill.h"

namespace fjell::baker {

namespace {

constexpr std::size_t window_samples = std::size_t{1} << 20;

// Readers that wait for a thread: opening one costs as much as reading a window.
class ReaderPool {
public:
    explicit ReaderPool(const HeightSource& source) : source_(source) {}
    [[nodiscard]] std::unique_ptr<HeightReader> take() {
        const std::lock_guard hold(lock_);
        if (free_.empty()) return source_.reader();
        auto reader = std::move(free_.back());
        free_.pop_back();
        return reader;
    }
    void give(std::unique_ptr<HeightReader> reader) {
        const std::lock_guard hold(lock_);
        free_.push_back(std::move(reader));
    }

private:
    const HeightSource& source_;
    std::mutex lock_;
    std::vector<std::unique_ptr<HeightReader>> free_;
};

} // namespace

void Pipeline::read() {
    const std::uint32_t stage = index(Stage::read);
    // Kept for colours and normals; gone when those are made, or when the filled ones are.
    const bool filled = done(index(Stage::fill)) && ledger_.state.has_voids;
    if (!done(index(Stage::vertices)) && !filled) raw_ = {file("heights"), tree_.columns(), tree_.rows()};
    if (done(stage)) return;
    const std::vector<Window> windows = source_.windows(window_samples);
    std::size_t largest = 0;
    for (const Window& w : windows) largest = std::max(largest, w.area());
    std::vector<Census> met(windows.size());
    ReaderPool readers(source_);
    const int workers = std::min(source_.readers(threads_), workers_for(largest * 2 * sizeof(float)));
    const double each = static_cast<double>(tree_.columns()) * tree_.rows() / static_cast<double>(windows.size());
    input_at_work_ = true;
    run_units(
        {stage, "read", windows.size(), workers, each, [&](std::uint64_t i) { ledger_.state.census.add(met[i]); }},
        [&](std::uint64_t i) {
            std::unique_ptr<HeightReader> reader = readers.take();
            Buffer<float> heights(windows[i].area());
            reader->read(windows[i], heights.data(), met[i]);
            raw_.write(windows[i], heights.data(), windows[i].columns);
            readers.give(std::move(reader));
        });
    input_at_work_ = false;
    const Settled settled = source_.settle(ledger_.state.census);
    LedgerState& state = ledger_.state;
    state.has_voids = state.census.voids.count + state.census.odd.count > 0;
    state.holes = settled.holes && state.has_voids;
    state.native_quantum_m = settled.native_quantum_m;
    state.anchor_m = settled.anchor_m;
    finish(stage);
}

void Pipeline::fill() {
    const std::uint32_t stage = index(Stage::fill);
    const LedgerState& state = ledger_.state;
    const std::int32_t columns = tree_.columns(), rows = tree_.rows();
    if (state.has_voids && !done(index(Stage::vertices))) {
        filled_ = {file("filled"), columns, rows};
        if (state.holes) voids_ = {file("voids"), columns, rows};
    }
    if (done(stage)) return;
    if (state.has_voids) {
        if (options_.progress) options_.progress("fill", 0, 1);
        if (state.holes) {
            constexpr std::int32_t band = 64;
            parallel_for((rows - 1) / band + 1, threads_, [&](std::int64_t i) {
                const auto y = static_cast<std::int32_t>(i) * band;
                const Window w{0, y, columns, std::min(band, rows - y)};
                std::vector<float> heights(w.area());
                std::vector<std::uint8_t> voids(w.area());
                raw_.read(w, heights.data(), columns);
                std::transform(heights.begin(), heights.end(), voids.begin(),
                               [](float h) { return static_cast<std::uint8_t>(std::isnan(h)); });
                voids_.write(w, voids.data(), columns);
            });
        }
        constexpr std::uint64_t piece_bytes = std::uint64_t{24} << 20;
        fill_voids(
            {raw_,
             {state.native_quantum_m, state.anchor_m},
             workers_for(piece_bytes),
             [&](const std::string& name, std::int64_t w, std::int64_t h) { return Store<float>(file(name), w, h); }},
            filled_);
    }
    finish(stage);
    if (state.has_voids) raw_.remove();
}

Survey Pipeline::survey_region(const Region& region, Buffer<float>& buffer) const {
    const Coord last = tree_.sample(region.last);
    const Window w{region.first.x, region.first.y, last.x - region.first.x + 1, last.y - region.first.y + 1};
    buffer.resize(w.area());
    heights().read(w, buffer.data(), w.columns);
    Survey all;
    regions_.for_each_tile(region, [&](std::uint32_t, Coord corner) {
        const Coord end = tree_.sample({corner.x + tree_.side(), corner.y + tree_.side()});
        all.add(survey_tile(buffer.data() + std::ptrdiff_t{corner.y - w.y} * w.columns + (corner.x - w.x),
                            end.x - corner.x + 1, end.y - corner.y + 1, w.columns));
    });
    if (!voids_.exists()) return all;
    // Borders count where the region to the south or east does, and on the terrain's rim.
    const Window own{w.x, w.y, w.columns - (last.x + 1 < tree_.columns()), w.rows - (last.y + 1 < tree_.rows())};
    std::vector<std::uint8_t> voids(own.area());
    voids_.read(own, voids.data(), own.columns);
    all.voids = static_cast<std::uint64_t>(std::count(voids.begin(), voids.end(), std::uint8_t{1}));
    return all;
}

void Pipeline::survey() {
    const std::uint32_t stage = index(Stage::survey);
    if (done(stage)) return;
    ledger_.state.survey = {};
    ledger_.state.done = 0; // what it gathers lies in memory: from its beginning
    std::vector<Survey> found(static_cast<std::size_t>(regions_.count()));
    const double side = regions_.cells() + 1.0;
    run_units({stage, "survey", found.size(), workers_for(static_cast<std::uint64_t>(side * side * 5)),
               static_cast<double>(tree_.columns()) * tree_.rows() / static_cast<double>(found.size())},
              [&](std::uint64_t i) {
                  thread_local Buffer<float> buffer;
                  found[i] = survey_region(regions_.at(static_cast<std::int64_t>(i)), buffer);
              });
    for (const Survey& s : found) ledger_.state.survey.add(s);
    finish(stage);
}

} // namespace fjell::baker
