#include "editor/jobs/overview.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <numbers>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

#include "fjell/gl/ground_colour.h"
#include "fjell/io/failure.h"
#include "fjell/io/load.h"
#include "fjell/pages.h"
#include "fjell/query.h"
#include "fjell/terrain.h"
#include "fjell/texture.h"

namespace fjell::editor {

namespace {

constexpr std::chrono::milliseconds overview_shown_every{100};

using Colour = std::array<float, 3>; // sRGB, 0 to 255
// By height, from the lowest ground to the highest.
constexpr Colour ramp[] = {{84, 118, 84},  {124, 146, 92},  {176, 168, 112},
                           {168, 134, 98}, {178, 166, 156}, {240, 242, 246}};
// What shaders draw level ground without a colour map in (rock() of runtime/gl/shaders.cpp), for layers to lie on.
constexpr Colour bare{162, 156, 145};

Colour mixed(const Colour& a, const Colour& b, float share) {
    Colour c{};
    for (std::size_t k = 0; k < 3; ++k) c[k] = a[k] + (b[k] - a[k]) * share;
    return c;
}

Colour ramp_at(float share) {
    constexpr auto last = static_cast<float>(std::size(ramp) - 1);
    const float at = std::clamp(share, 0.0F, 1.0F) * last;
    const auto i = std::min(static_cast<std::size_t>(at), std::size(ramp) - 2);
    return mixed(ramp[i], ramp[i + 1], at - static_cast<float>(i));
}

std::uint32_t packed(const Colour& c) {
    std::uint32_t value = 0xff000000u;
    for (std::size_t k = 0; k < 3; ++k) value |= static_cast<std::uint32_t>(std::clamp(c[k], 0.0F, 255.0F)) << (8 * k);
    return value;
}

double extent_m(std::uint32_t samples, double spacing_m) {
    return (samples - 1) * spacing_m;
}

// A tile's colours: a square of texels, the first and the last on the tile's border, as maps lie.
struct TileColours {
    std::uint32_t side = 0; // 0: none
    std::vector<std::uint8_t> rgb;

    // u, v: 0 to 1 over the tile.
    [[nodiscard]] Colour at(double u, double v) const {
        const auto place = [this](double share) { return std::clamp(share, 0.0, 1.0) * (side - 1); };
        const double x = place(u), y = place(v);
        const auto i = std::min(static_cast<std::uint32_t>(x), side - 2),
                   j = std::min(static_cast<std::uint32_t>(y), side - 2);
        const auto texel = [&](std::uint32_t column, std::uint32_t row) {
            const std::uint8_t* const c = &rgb[3 * (std::size_t{row} * side + column)];
            return Colour{static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
        };
        const auto along = static_cast<float>(x - i), down = static_cast<float>(y - j);
        return mixed(mixed(texel(i, j), texel(i + 1, j), along), mixed(texel(i, j + 1), texel(i + 1, j + 1), along),
                     down);
    }
};

class Painter {
public:
    Painter(const OverviewSource& source, const std::function<bool()>& stopped);
    bool paint(const OverviewShow& show);

private:
    struct Texels { // of a tile: those whose centres lie in it
        std::uint32_t column = 0, end_column = 0, row = 0, end_row = 0;
        [[nodiscard]] bool empty() const { return column >= end_column || row >= end_row; }
    };
    void choose_layers();
    [[nodiscard]] Texels texels_of(SampleIndex tile) const;
    [[nodiscard]] GroundHeight ground(double x, double z) const;
    void load_pages(std::uint32_t tile);
    void unload_pages(std::uint32_t tile);
    void read_colours(std::uint32_t tile);
    void paint_layers(std::uint32_t tile);
    bool paint_tile(std::uint32_t tile, const Texels& texels);
    [[nodiscard]] bool show(double share, const OverviewShow& to);
    void shade(std::size_t column, std::size_t row);

    const OverviewSource& source_;
    const std::function<bool()>& stopped_;
    const PackHeader& header_;
    OverviewSize size_;
    double texel_x_m_ = 1, texel_z_m_ = 1, tile_x_m_ = 1, tile_z_m_ = 1;
    float accurate_m_ = 0;
    int step_log2_ = 0;        // of samples that texels are about apart: finer pages are not read
    std::uint32_t wanted_ = 2; // texels a side, of a tile's colours
    std::uint32_t colour_mip_ = 0;
    bool by_height_ = false, layered_ = false, mapped_ = false; // mapped: by splat maps, not by rules
    gl::GroundColour ground_colour_;
    io::AlignedMemory memory_;
    Terrain terrain_;
    std::vector<std::byte> raw_;
    std::vector<float> patch_height_m_, patch_slope_deg_;
    TileColours colours_;
    std::vector<float> heights_; // NaN: no ground, or not yet
    std::vector<Colour> colour_;
    std::vector<std::uint32_t> texels_;
};

Painter::Painter(const OverviewSource& source, const std::function<bool()>& stopped)
    : source_(source), stopped_(stopped), header_(source.pack->pack().header), size_(overview_size_of(header_)) {
    texel_x_m_ = extent_m(header_.columns, header_.spacing_m[0]) / size_.columns;
    texel_z_m_ = extent_m(header_.rows, header_.spacing_m[1]) / size_.rows;
    const double cells = 1u << header_.tile_log2;
    tile_x_m_ = cells * header_.spacing_m[0];
    tile_z_m_ = cells * header_.spacing_m[1];
    accurate_m_ = (header_.max_m - header_.min_m) / 512; // finer than a texel's shade
    const double samples = std::min(texel_x_m_ / header_.spacing_m[0], texel_z_m_ / header_.spacing_m[1]);
    step_log2_ = std::max(static_cast<int>(std::floor(std::log2(std::max(samples, 1.0)))), 0);
    const double across = std::max(tile_x_m_ / texel_x_m_, tile_z_m_ / texel_z_m_);
    wanted_ = static_cast<std::uint32_t>(std::clamp(std::ceil(across) + 1, 2.0, 1024.0));
    for (std::uint32_t log2 = header_.colour_log2; log2 > 2 && 1u << (log2 - 1) >= wanted_; --log2) ++colour_mip_;
    choose_layers();
    by_height_ = header_.colour_log2 == 0 && !layered_;
    const TerrainBudget slots{pages_per_tile(header_)};
    const std::size_t bytes = terrain_bytes(header_, slots);
    memory_ = io::allocate(bytes);
    const Status made =
        create_terrain(source.pack->pack(), source.pack->corners(), slots, {memory_.get(), bytes}, terrain_);
    if (!made.ok()) throw io::Failure(1, source.pack->path() + ": " + message(made.code));
    heights_.assign(size_.texels(), std::numeric_limits<float>::quiet_NaN());
    colour_.assign(size_.texels(), bare);
    texels_.assign(size_.texels(), overview_ground);
}

// Layers that cannot be laid are said by the renderer, which needs the same.
void Painter::choose_layers() {
    if (!source_.layers || !source_.settings.on) return;
    const session::GroundLayers& layers = *source_.layers;
    try {
        std::vector<std::string> names;
        if (header_.layer_bytes != 0) {
            source_.pack->read_chunk({ChunkKind::layers, 0, 0}, raw_);
            names = io::layer_names({reinterpret_cast<const char*>(raw_.data()), raw_.size()});
        }
        mapped_ = !names.empty() && source_.settings.splat;
        if (!mapped_ && layers.rules.empty()) return;
        ground_colour_.set(layers.materials, layers.rules, names, source_.settings,
                           std::max(tile_x_m_, tile_z_m_) / (wanted_ - 1));
        layered_ = true;
    } catch (const io::Failure&) {
        layered_ = false;
    }
}

// Centres on a border are those of the tile in the south-east.
Painter::Texels Painter::texels_of(SampleIndex tile) const {
    const auto first = [](double at_m, double texel_m, std::uint32_t all) {
        return static_cast<std::uint32_t>(std::clamp(std::ceil(at_m / texel_m - 0.5), 0.0, static_cast<double>(all)));
    };
    return {first(tile.column * tile_x_m_, texel_x_m_, size_.columns),
            first((tile.column + 1) * tile_x_m_, texel_x_m_, size_.columns),
            first(tile.row * tile_z_m_, texel_z_m_, size_.rows),
            first((tile.row + 1) * tile_z_m_, texel_z_m_, size_.rows)};
}

GroundHeight Painter::ground(double x, double z) const {
    return ground_height(terrain_, x, z, accurate_m_);
}

void Painter::load_pages(std::uint32_t tile) {
    for (std::uint32_t page = 0; page < terrain_.pages_per_tile() && !stopped_(); ++page) {
        const int step = page_step_log2(terrain_.header(), page); // -1: of all steps, or page 0, which all need
        if (step >= 0 && step < step_log2_) continue;
        try {
            source_.pack->read_chunk({ChunkKind::geometry, tile, page}, raw_);
            (void)insert_page(terrain_, tile, page, raw_); // a damaged one: it is as coarse as those over it
        } catch (const io::Failure&) {                     // the flight says what cannot be read
        }
    }
}

void Painter::unload_pages(std::uint32_t tile) {
    for (std::uint32_t page = 0; page < terrain_.pages_per_tile(); ++page) (void)unload_page(terrain_, tile, page);
}

void Painter::read_colours(std::uint32_t tile) {
    colours_.side = 0;
    if (by_height_) return;
    if (header_.colour_log2 != 0) {
        const std::uint32_t side = 1u << (header_.colour_log2 - colour_mip_);
        colours_.rgb.resize(3 * std::size_t{side} * side);
        try {
            source_.pack->read_chunk({ChunkKind::colour, tile, colour_mip_}, raw_);
            if (decode_colour(raw_, side, colours_.rgb).ok()) colours_.side = side;
        } catch (const io::Failure&) { // as above
        }
    }
    if (layered_) paint_layers(tile);
}

void Painter::paint_layers(std::uint32_t tile) {
    if (colours_.side == 0) {
        colours_.side = wanted_;
        colours_.rgb.resize(3 * std::size_t{wanted_} * wanted_);
        for (std::size_t i = 0; i < colours_.rgb.size(); ++i) colours_.rgb[i] = static_cast<std::uint8_t>(bare[i % 3]);
    }
    const std::uint32_t side = colours_.side;
    const SampleIndex at = terrain_.tile_place(tile);
    gl::GroundTexels texels{side, at.column * tile_x_m_, at.row * tile_z_m_, tile_x_m_ / (side - 1),
                            tile_z_m_ / (side - 1)};
    if (mapped_) {
        std::uint32_t log2 = header_.splat_log2, mip = 0;
        for (; log2 > 2 && 1u << log2 > side; --log2) ++mip;
        try {
            source_.pack->read_chunk({ChunkKind::splat, tile, mip}, raw_);
        } catch (const io::Failure&) {
            return;
        }
        texels.splat = raw_;
        texels.splat_side = 1u << log2;
    } else {
        patch_height_m_.resize(std::size_t{side} * side);
        patch_slope_deg_.resize(patch_height_m_.size());
        // The last texels lie on the border, whose slopes would be the next tile's, and that one's pages are not there.
        const double end_x_m = texels.x_m + (side - 1.001) * texels.step_x_m,
                     end_z_m = texels.z_m + (side - 1.001) * texels.step_z_m;
        for (std::uint32_t row = 0; row < side && !stopped_(); ++row)
            for (std::uint32_t column = 0; column < side; ++column) {
                const GroundHeight g = ground(std::min(texels.x_m + column * texels.step_x_m, end_x_m),
                                              std::min(texels.z_m + row * texels.step_z_m, end_z_m));
                const std::size_t i = std::size_t{row} * side + column;
                patch_height_m_[i] = static_cast<float>(g.height_m);
                patch_slope_deg_[i] =
                    static_cast<float>(std::acos(std::clamp(g.normal.y, -1.0, 1.0)) * 180 / std::numbers::pi);
            }
        texels.height_m = patch_height_m_;
        texels.slope_deg = patch_slope_deg_;
    }
    texels.rgb = colours_.rgb;
    (void)ground_colour_.paint(texels);
}

bool Painter::paint_tile(std::uint32_t tile, const Texels& texels) {
    // A texel a tile needs no more than the corners, which are there always.
    if (wanted_ > 2) load_pages(tile);
    read_colours(tile);
    const SampleIndex at = terrain_.tile_place(tile);
    const float low = header_.min_m, range = std::max(header_.max_m - header_.min_m, 1e-6F);
    for (std::uint32_t row = texels.row; row < texels.end_row && !stopped_(); ++row)
        for (std::uint32_t column = texels.column; column < texels.end_column; ++column) {
            const double x = (column + 0.5) * texel_x_m_, z = (row + 0.5) * texel_z_m_;
            const GroundHeight g = ground(x, z);
            if (g.hole || !g.inside) continue;
            const std::size_t i = std::size_t{row} * size_.columns + column;
            heights_[i] = static_cast<float>(g.height_m);
            if (by_height_)
                colour_[i] = ramp_at((heights_[i] - low) / range);
            else if (colours_.side != 0)
                colour_[i] = colours_.at(x / tile_x_m_ - at.column, z / tile_z_m_ - at.row);
        }
    unload_pages(tile);
    return !stopped_();
}

// By the heights to the west and to the north.
void Painter::shade(std::size_t column, std::size_t row) {
    const std::size_t i = row * size_.columns + column;
    if (std::isnan(heights_[i])) return;
    const auto slope = [&](bool there, std::size_t before, double step_m) {
        const float rise = there && !std::isnan(heights_[before]) ? heights_[i] - heights_[before] : 0.0F;
        return 3 * rise / static_cast<float>(step_m);
    };
    const float sx = slope(column > 0, i - 1, texel_x_m_), sz = slope(row > 0, i - size_.columns, texel_z_m_);
    const float light = (0.5F * (sx + sz) + 0.71F) / std::sqrt(sx * sx + sz * sz + 1);
    Colour c = colour_[i];
    for (float& v : c) v *= 0.35F + 0.9F * std::clamp(light, 0.0F, 1.0F);
    texels_[i] = packed(c);
}

bool Painter::show(double share, const OverviewShow& to) {
    for (std::uint32_t row = 0; row < size_.rows; ++row)
        for (std::uint32_t column = 0; column < size_.columns; ++column) shade(column, row);
    return to(share, texels_);
}

bool Painter::paint(const OverviewShow& to) {
    auto shown = std::chrono::steady_clock::now();
    const std::uint32_t tiles = terrain_.tile_count();
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
        if (stopped_()) return false;
        const Texels texels = texels_of(terrain_.tile_place(tile));
        if (texels.empty()) continue;
        if (!paint_tile(tile, texels)) return false;
        if (std::chrono::steady_clock::now() - shown < overview_shown_every) continue;
        if (!show((tile + 1.0) / (tiles + 1.0), to)) return false;
        shown = std::chrono::steady_clock::now();
    }
    return show(1, to);
}

} // namespace

OverviewSize overview_size_of(const PackHeader& h) {
    const double w = extent_m(h.columns, h.spacing_m[0]), d = extent_m(h.rows, h.spacing_m[1]), longer = std::max(w, d);
    const auto texels = [&](double m) {
        const auto n = static_cast<std::uint32_t>(std::lround(OverviewSize::longer_texels * m / longer));
        return std::clamp(n, OverviewSize::least_texels, OverviewSize::longer_texels);
    };
    return {texels(w), texels(d)};
}

bool paint_overview(const OverviewSource& source, const std::function<bool()>& stopped, const OverviewShow& show) {
    if (stopped()) return false;
    return Painter(source, stopped).paint(show);
}

// --- The thread that paints it.

namespace {

// The picture comes first: where processors are few, the overview a little later.
void step_back() {
    (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 5);
}

} // namespace

struct OverviewJob::Sheet {
    std::mutex lock; // of what follows
    std::vector<std::uint32_t> texels;
    double share = 0;
    // Without the lock: what it guards has changed since it was taken; and the thread will not come back to it.
    std::atomic<bool> changed{false}, ended{false};
    OverviewSize size; // never changes
};

OverviewJob::~OverviewJob() {
    leave();
}

// A thread that is left has been told to stop by then, so joining all of them takes no longer than the slowest.
void OverviewJob::leave() {
    std::erase_if(leaving_, [](const Painting& p) { return p.sheet->ended.load(std::memory_order_acquire); });
    if (now_.thread.joinable()) {
        now_.thread.request_stop();
        leaving_.push_back(std::move(now_));
    }
    now_ = {};
}

void OverviewJob::begin(OverviewSource source) {
    leave();
    auto sheet = std::make_shared<Sheet>();
    sheet->size = overview_size_of(source.pack->pack().header);
    sheet->texels.assign(sheet->size.texels(), overview_ground);
    now_.sheet = sheet;
    try {
        now_.thread = std::jthread([sheet, source = std::move(source)](const std::stop_token& stop) {
            paint(*sheet, source, stop);
            sheet->ended.store(true, std::memory_order_release);
        });
    } catch (const std::system_error&) { // the machine gives no thread: there is no overview
        sheet->ended.store(true, std::memory_order_release);
    }
}

void OverviewJob::end() {
    leave();
}

void OverviewJob::paint(Sheet& sheet, const OverviewSource& source, const std::stop_token& stop) {
    step_back();
    try {
        (void)paint_overview(
            source, [&] { return stop.stop_requested(); },
            [&](double share, std::span<const std::uint32_t> texels) {
                {
                    const std::scoped_lock hold(sheet.lock);
                    std::ranges::copy(texels, sheet.texels.begin());
                    sheet.share = share;
                }
                sheet.changed.store(true, std::memory_order_release);
                return !stop.stop_requested();
            });
    } catch (const std::exception&) { // the flight needs the same memory and the same file, and says what is wrong
    }
}

bool OverviewJob::news() const {
    return now_.sheet && now_.sheet->changed.load(std::memory_order_acquire);
}

bool OverviewJob::done() const {
    return !now_.sheet || (now_.sheet->ended.load(std::memory_order_acquire) && !news());
}

bool OverviewJob::take(Take give, void* to) {
    if (!now_.sheet) return false;
    Sheet& sheet = *now_.sheet;
    const std::unique_lock hold(sheet.lock, std::try_to_lock);
    if (!hold) return false;
    sheet.changed.store(false, std::memory_order_relaxed); // before what is read, as the thread sets it after writing
    give(to, sheet.size, sheet.share, sheet.texels);
    return true;
}

} // namespace fjell::editor
