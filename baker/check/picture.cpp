#include "baker/check/picture.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <stb_easy_font.h>
#include <stb_image_write.h>

#include "baker/store/parallel.h"
#include "fjell/io/failure.h"
#include "shared/terrain_data.h"

namespace fjell::baker {

namespace {

using Tint = std::array<float, 3>; // what light a colour lets through

constexpr Tint no_error{1, 1, 1};
constexpr float flat_ground = 0.75f, shadow = 0.28f; // brightness of relief

// Blue, yellow and red stay apart in every common form of colour blindness, and the share of red grows all the way.
Tint error_tint(float t) {
    constexpr Tint anchors[] = {{0.55f, 0.75f, 1.00f},
                                {0.68f, 0.92f, 0.80f},
                                {1.00f, 0.92f, 0.50f},
                                {1.00f, 0.60f, 0.25f},
                                {0.86f, 0.12f, 0.12f}};
    constexpr int spans = static_cast<int>(std::size(anchors)) - 1;
    const float at = std::clamp(t, 0.0f, 1.0f) * spans;
    const int i = std::min(static_cast<int>(at), spans - 1);
    const float f = at - static_cast<float>(i);
    Tint tint{};
    for (std::size_t c = 0; c < 3; ++c) tint[c] = anchors[i][c] * (1 - f) + anchors[i + 1][c] * f;
    return tint;
}

Rgb8 lit(float brightness, const Tint& tint) {
    Rgb8 rgb{};
    for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(brightness * tint[c], 0.0f, 1.0f)));
    return rgb;
}

// The same spot under a tile line. Ground at the threshold changes by about 75 either way, everything else by more.
Rgb8 lined(const Rgb8& ground) {
    if (ground == hole_rgb) return hole_line_rgb;
    const float luminance = 0.2126f * static_cast<float>(ground[0]) + 0.7152f * static_cast<float>(ground[1]) +
                            0.0722f * static_cast<float>(ground[2]);
    const float towards = luminance < 105 ? 255 : 0, share = luminance < 105 ? 0.5f : 0.7f;
    Rgb8 rgb{};
    for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = static_cast<std::uint8_t>(std::lround(static_cast<float>(ground[c]) * (1 - share) + towards * share));
    return rgb;
}

// The terrain, one cell a pixel, or one a sample when the terrain has fewer.
struct PixelSamples {
    std::int32_t columns = 0, rows = 0;
    std::vector<float> height_m, error_m;
    std::vector<std::uint8_t> hole;
    bool some_hole = false;

    [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
    }
};

// Samples [x0, x1) x [y0, y1): every sample is in one cell.
struct Footprint {
    std::int32_t x0, x1, y0, y1;
};

std::int32_t share(std::int32_t i, std::int32_t samples, std::int32_t cells) {
    return static_cast<std::int32_t>(std::int64_t{i} * samples / cells);
}

class Sampler {
public:
    Sampler(const Terrain& the_terrain, std::int32_t width, std::int32_t height)
        : terrain(the_terrain), tree(data_of(the_terrain).tree) {
        cells.columns = std::min(width, tree.columns());
        cells.rows = std::min(height, tree.rows());
        const std::size_t count = static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows);
        cells.height_m.resize(count);
        cells.error_m.resize(count);
        cells.hole.resize(count);
        // The coarsest step of which every cell has a vertex: two of its places one way and one the other.
        const std::int32_t nx = tree.columns() / cells.columns, ny = tree.rows() / cells.rows;
        while (step < tree.side() / 2 && 4 * step <= std::max(nx, ny) && 2 * step <= std::min(nx, ny)) step *= 2;
        rim_error_m = static_cast<float>(2 * step) * std::min(terrain.spacing_x_m(), terrain.spacing_z_m()) * 0.999f;
    }

    PixelSamples run(int threads) {
        parallel_for(cells.rows, threads, [&](std::int64_t y) { sample_row(static_cast<std::int32_t>(y)); });
        if (terrain.has_voids())
            parallel_for(cells.rows, threads, [&](std::int64_t y) { find_holes(static_cast<std::int32_t>(y)); });
        cells.some_hole = std::find(cells.hole.begin(), cells.hole.end(), 1) != cells.hole.end();
        return std::move(cells);
    }

private:
    [[nodiscard]] Footprint footprint(std::int32_t x, std::int32_t y) const {
        return {share(x, tree.columns(), cells.columns), share(x + 1, tree.columns(), cells.columns),
                share(y, tree.rows(), cells.rows), share(y + 1, tree.rows(), cells.rows)};
    }

    void sample_row(std::int32_t y) {
        for (std::int32_t x = 0; x < cells.columns; ++x) {
            const Footprint f = footprint(x, y);
            const std::int32_t w = f.x1 - f.x0, h = f.y1 - f.y0;
            float sum = 0;
            for (const std::int32_t j : {h / 4, h * 3 / 4})
                for (const std::int32_t i : {w / 4, w * 3 / 4}) sum += data_of(terrain).height_m({f.x0 + i, f.y0 + j});
            cells.height_m[cells.index(x, y)] = sum / 4;
            cells.error_m[cells.index(x, y)] = largest_error_m(f);
        }
    }

    // A single sample takes a neighbour: every square of 2 x 2 has three vertices of step 1.
    static std::pair<std::int32_t, std::int32_t> reach(std::int32_t first, std::int32_t end, std::int32_t samples) {
        if (end - first >= 2) return {first, end};
        return end < samples ? std::pair(first, end + 1) : std::pair(first - 1, end);
    }

    // Of the vertices of `step`: places of its height scale that no coarser step has.
    [[nodiscard]] float largest_error_m(const Footprint& f) const {
        const auto [x0, x1] = reach(f.x0, f.x1, tree.columns());
        const auto [y0, y1] = reach(f.y0, f.y1, tree.rows());
        assert(x0 >= 0 && x1 <= tree.columns() && y0 >= 0 && y1 <= tree.rows());
        float largest_m = 0;
        for (std::int32_t j = (y0 + step - 1) / step; j * step < y1; ++j)
            for (std::int32_t i = (x0 + step - 1) / step; i * step < x1; ++i)
                if ((i | j) & 1) largest_m = std::max(largest_m, data_of(terrain).vertex({i * step, j * step}).error_m);
        return largest_m;
    }

    // Over a hole's rim a triangle's error is at least its own size (verify.h: rim violations). The sides' diamonds of
    // `step` that touch a cell have their centres in it or beside it: where all errors are smaller, no rim is near, and
    // one sample tells for all. In the last cells triangles may be squeezed to any size: there all samples are asked.
    void find_holes(std::int32_t y) {
        for (std::int32_t x = 0; x < cells.columns; ++x) {
            const Footprint f = footprint(x, y);
            bool hole = data_of(terrain).is_hole({f.x0, f.y0});
            if (!hole && rim_near(x, y))
                for (std::int32_t j = f.y0; j < f.y1 && !hole; ++j)
                    for (std::int32_t i = f.x0; i < f.x1 && !hole; ++i) hole = data_of(terrain).is_hole({i, j});
            cells.hole[cells.index(x, y)] = hole;
        }
    }

    [[nodiscard]] bool rim_near(std::int32_t x, std::int32_t y) const {
        if (x >= cells.columns - 2 || y >= cells.rows - 2) return true;
        for (std::int32_t j = std::max(y - 1, 0); j <= std::min(y + 1, cells.rows - 1); ++j)
            for (std::int32_t i = std::max(x - 1, 0); i <= std::min(x + 1, cells.columns - 1); ++i)
                if (cells.error_m[cells.index(i, j)] >= rim_error_m) return true;
        return false;
    }

    const Terrain& terrain;
    const Tree tree;
    PixelSamples cells;
    std::int32_t step = 1; // of the vertices whose errors are shown
    float rim_error_m = 0;
};

// Central differences, one-sided on the rim; metres a metre, to the east and to the south.
struct Slope {
    float east = 0, south = 0;
};

struct Relief {
    const PixelSamples& cells;
    float cell_x_m, cell_z_m;
    float exaggeration = 1;

    Relief(const Terrain& terrain, const PixelSamples& of)
        : cells(of), cell_x_m(terrain.spacing_x_m() * static_cast<float>(data_of(terrain).tree.columns()) /
                              static_cast<float>(of.columns)),
          cell_z_m(terrain.spacing_z_m() * static_cast<float>(data_of(terrain).tree.rows()) /
                   static_cast<float>(of.rows)) {
        double sum = 0, count = 0;
        for (std::int32_t y = 0; y < cells.rows; ++y)
            for (std::int32_t x = 0; x < cells.columns; ++x) {
                if (cells.hole[cells.index(x, y)]) continue;
                const Slope s = slope(x, y);
                sum += static_cast<double>(s.east * s.east + s.south * s.south);
                ++count;
            }
        // Typical slopes are drawn as if they were two high and five long; lowland is not blown up beyond recognition.
        if (sum > 0) exaggeration = std::clamp(static_cast<float>(0.4 / std::sqrt(sum / count)), 0.05f, 20.0f);
    }

    [[nodiscard]] Slope slope(std::int32_t x, std::int32_t y) const {
        const std::int32_t w = std::max(x - 1, 0), e = std::min(x + 1, cells.columns - 1);
        const std::int32_t n = std::max(y - 1, 0), s = std::min(y + 1, cells.rows - 1);
        const auto h = [&](std::int32_t i, std::int32_t j) { return cells.height_m[cells.index(i, j)]; };
        return {e == w ? 0 : (h(e, y) - h(w, y)) / (static_cast<float>(e - w) * cell_x_m),
                s == n ? 0 : (h(x, s) - h(x, n)) / (static_cast<float>(s - n) * cell_z_m)};
    }

    [[nodiscard]] float brightness(std::int32_t x, std::int32_t y) const {
        const Slope s = slope(x, y);
        const float east = s.east * exaggeration, south = s.south * exaggeration;
        // Light from the north-west, 45 degrees above the horizon.
        const float lambert = (0.5f * (east + south) + 0.70711f) / std::sqrt(east * east + south * south + 1);
        return shadow + (flat_ground - shadow) / 0.70711f * std::max(lambert, 0.0f);
    }
};

// The logarithmic ramp's ends, over what is seen of the terrain. Errors at the rims of holes are as large as the
// triangles there and would leave the ground one colour: they count only when there are no others.
struct PictureRamp {
    float least_m = 0, largest_m = 0;
    bool some_without = false, some_larger = false; // error 0 occurs; one beyond the end does, at a rim

    explicit PictureRamp(const PixelSamples& cells) {
        float rim_least_m = 0, rim_largest_m = 0;
        for (std::int32_t y = 0; y < cells.rows; ++y)
            for (std::int32_t x = 0; x < cells.columns; ++x) {
                if (cells.hole[cells.index(x, y)]) continue;
                const float e = cells.error_m[cells.index(x, y)];
                if (e <= 0)
                    some_without = true;
                else if (cells.some_hole && hole_near(cells, x, y))
                    widen(rim_least_m, rim_largest_m, e);
                else
                    widen(least_m, largest_m, e);
            }
        if (largest_m == 0) least_m = rim_least_m, largest_m = rim_largest_m;
        // At least a factor of ten, so that what is nearly the same also looks it.
        const float middle_m = std::sqrt(least_m * largest_m);
        if (largest_m < 10 * least_m) least_m = middle_m / std::sqrt(10.0f), largest_m = middle_m * std::sqrt(10.0f);
        some_larger = rim_largest_m > largest_m;
    }
    static void widen(float& least, float& most, float e) {
        least = most == 0 ? e : std::min(least, e);
        most = std::max(most, e);
    }
    // What a vertex' error bounds ends within three steps of it, and a cell is at least two wide, or is a single sample
    // with its neighbour.
    static bool hole_near(const PixelSamples& cells, std::int32_t x, std::int32_t y) {
        for (std::int32_t j = std::max(y - 3, 0); j <= std::min(y + 3, cells.rows - 1); ++j)
            for (std::int32_t i = std::max(x - 3, 0); i <= std::min(x + 3, cells.columns - 1); ++i)
                if (cells.hole[cells.index(i, j)]) return true;
        return false;
    }
    [[nodiscard]] Tint tint(float error_m) const {
        if (error_m <= 0) return no_error;
        return error_tint(std::log(error_m / least_m) / std::log(largest_m / least_m));
    }
};

struct Rect {
    std::int32_t x, y, width, height;
};

// colour(x, y): counted from the rectangle's corner. What lies outside the picture is left out.
void fill(Picture& picture, const Rect& r, const auto& colour) {
    const std::int32_t width = std::min(r.width, static_cast<std::int32_t>(picture.width) - r.x),
                       height = std::min(r.height, static_cast<std::int32_t>(picture.height) - r.y);
    for (std::int32_t y = 0; y < height; ++y)
        for (std::int32_t x = 0; x < width; ++x) {
            const Rgb8 rgb = colour(x, y);
            const auto px = static_cast<std::size_t>(r.x + x), py = static_cast<std::size_t>(r.y + y);
            std::memcpy(&picture.rgb[(py * picture.width + px) * 3], rgb.data(), 3);
        }
}

// Which columns and rows of the picture are tile lines.
struct TileLines {
    std::vector<std::uint8_t> columns, rows;
    std::int32_t every = 1; // tiles
    bool any = false;

    TileLines(const Tree& tree, const Picture& picture, std::uint32_t thickness)
        : columns(picture.width), rows(picture.terrain_height) {
        const double x_px = static_cast<double>(picture.width) / tree.columns(),
                     y_px = static_cast<double>(picture.terrain_height) / tree.rows(); // of a sample
        while (every < std::max(tree.tiles_x, tree.tiles_y) &&
               every * tree.side() * std::min(x_px, y_px) < 16 * thickness)
            every *= 2;
        any = every < std::max(tree.tiles_x, tree.tiles_y);
        for (std::int32_t k = every; k < tree.tiles_x; k += every)
            mark(columns, (k * tree.side() + 0.5) * x_px, thickness);
        for (std::int32_t k = every; k < tree.tiles_y; k += every)
            mark(rows, (k * tree.side() + 0.5) * y_px, thickness);
    }
    static void mark(std::vector<std::uint8_t>& at, double middle, std::uint32_t thickness) {
        const auto first = static_cast<std::size_t>(middle - (thickness - 1) / 2.0);
        for (std::size_t i = first; i < std::min(first + thickness, at.size()); ++i) at[i] = 1;
    }
};

// The legend: items of a box between two texts, set in lines that are as wide as the picture.
struct Item {
    std::string before, after;
    std::int32_t box = 0; // wide, in letters' units
    std::function<Rgb8(std::int32_t x, std::int32_t y)> colour;
};

constexpr Rgb8 paper{245, 245, 245}, ink{30, 30, 30};
constexpr std::int32_t line_height = 14, box_height = 9, gap = 5, margin = 6; // in letters' units

std::int32_t text_width(const std::string& text) {
    return stb_easy_font_width(const_cast<char*>(text.c_str())); // it only reads
}

void draw_text(Picture& picture, std::int32_t x, std::int32_t y, std::int32_t unit, const std::string& text) {
    // Rectangles of four corners, 16 bytes each; no letter has more than 16.
    std::vector<char> quads(text.size() * 16 * 64);
    const int count = stb_easy_font_print(0, 0, const_cast<char*>(text.c_str()), nullptr, quads.data(),
                                          static_cast<int>(quads.size()));
    for (int q = 0; q < count; ++q) {
        float least[2], most[2];
        std::memcpy(least, quads.data() + q * 64, sizeof least);
        std::memcpy(most, quads.data() + q * 64 + 32, sizeof most);
        const auto px = [&](float v) { return static_cast<std::int32_t>(v) * unit; };
        fill(picture, {x + px(least[0]), y + px(least[1]), px(most[0] - least[0]), px(most[1] - least[1])},
             [](auto, auto) { return ink; });
    }
}

std::string metres(double m, int digits) {
    const auto [value, unit] = m >= 1000   ? std::pair(m / 1000, "km")
                               : m >= 0.01 ? std::pair(m, "m")
                                           : std::pair(m * 1000, "mm");
    return value >= std::pow(10, digits - 1) ? fmt::format("{:.0f} {}", value, unit)
                                             : fmt::format("{:.{}g} {}", value, digits, unit);
}

std::string tile_text(const Terrain& terrain) {
    const double cells = data_of(terrain).tree.side();
    const std::string x = metres(cells * terrain.header().spacing_m[0], 3),
                      z = metres(cells * terrain.header().spacing_m[1], 3);
    return fmt::format("tile {} cells, {}", cells, x == z ? x : x + " x " + z);
}

class Legend {
public:
    Legend(std::vector<Item> the_items, std::int32_t width)
        : items(std::move(the_items)), unit(std::max(1, (width + 256) / 512)) {
        std::int32_t x = margin, line = 0;
        for (const Item& item : items) {
            const std::int32_t wide = item_width(item);
            if (x > margin && (x + wide + margin) * unit > width) x = margin, ++line;
            places.push_back({x, line});
            x += wide + 3 * gap;
        }
        lines = line + 1;
    }
    [[nodiscard]] std::int32_t height() const { return (lines * line_height + margin) * unit; }

    void draw(Picture& picture, std::int32_t top) const {
        fill(picture, {0, top, static_cast<std::int32_t>(picture.width), height()}, [](auto, auto) { return paper; });
        for (std::size_t i = 0; i < items.size(); ++i) {
            const Item& item = items[i];
            std::int32_t x = places[i].column * unit;
            const std::int32_t y = top + (margin + places[i].row * line_height) * unit;
            const auto text = [&](const std::string& words) {
                if (words.empty()) return;
                draw_text(picture, x, y, unit, words);
                x += (text_width(words) + gap) * unit;
            };
            text(item.before);
            if (item.box) {
                fill(picture, {x, y, item.box * unit, box_height * unit},
                     [&](auto bx, auto by) { return item.colour(bx / unit, by / unit); });
                x += (item.box + gap) * unit;
            }
            text(item.after);
        }
    }

private:
    static std::int32_t item_width(const Item& item) {
        const auto with_gap = [](std::int32_t wide) { return wide ? wide + gap : 0; };
        return with_gap(text_width(item.before)) + with_gap(item.box) + with_gap(text_width(item.after)) - gap;
    }

    std::vector<Item> items;
    std::int32_t unit; // pixels of a letters' unit
    std::vector<SampleIndex> places;
    std::int32_t lines = 0;
};

std::vector<Item> legend_items(const Terrain& terrain, const PixelSamples& cells, const PictureRamp& ramp,
                               const TileLines& lines) {
    constexpr std::int32_t ramp_box = 60, box = 14;
    std::vector<Item> items;
    if (ramp.largest_m > 0)
        items.push_back({"error " + metres(ramp.least_m, 2),
                         metres(ramp.largest_m, 2) + (ramp.some_larger ? " or more" : ""), ramp_box, [](auto bx, auto) {
                             return lit(flat_ground, error_tint(static_cast<float>(bx) / (ramp_box - 1)));
                         }});
    if (ramp.some_without)
        items.push_back({"", "no error", box, [](auto, auto) { return lit(flat_ground, no_error); }});
    if (cells.some_hole)
        items.push_back(
            {"", fmt::format("hole ({} samples)", terrain.header().voids), box, [](auto, auto) { return hole_rgb; }});
    // A line over light and dark ground.
    const std::int32_t tile_box = lines.any ? box : 0;
    items.push_back({"", tile_text(terrain), tile_box, [](auto bx, auto by) {
                         const Rgb8 ground = lit(bx < box / 2 ? flat_ground : 0.25f, no_error);
                         return by == box_height / 2 ? lined(ground) : ground;
                     }});
    if (lines.any && lines.every > 1) items.push_back({"", fmt::format("a line every {} tiles", lines.every), 0, {}});
    return items;
}

} // namespace

Picture make_picture(const Terrain& terrain, const PictureOptions& options) {
    assert(terrain.pages_missing() == 0);
    const std::uint32_t longest = std::clamp(options.longest_px, min_picture_px, max_picture_px);
    const double wide_m = data_of(terrain).tree.columns() * terrain.header().spacing_m[0];
    const double high_m = data_of(terrain).tree.rows() * terrain.header().spacing_m[1];
    const auto pixels = [&](double m) {
        return static_cast<std::uint32_t>(std::max(std::lround(longest * m / std::max(wide_m, high_m)), 1L));
    };
    Picture picture;
    picture.width = pixels(wide_m);
    picture.terrain_height = pixels(high_m);
    const auto width = static_cast<std::int32_t>(picture.width),
               height = static_cast<std::int32_t>(picture.terrain_height);

    const int threads = resolve_threads(options.threads);
    const PixelSamples cells = Sampler(terrain, width, height).run(threads);
    const Relief relief(terrain, cells);
    const PictureRamp ramp(cells);
    picture.least_error_m = ramp.least_m;
    picture.largest_error_m = ramp.largest_m;
    const std::uint32_t thickness = std::max(1u, longest / 2048);
    const TileLines lines(data_of(terrain).tree, picture, thickness);

    const Legend legend(legend_items(terrain, cells, ramp, lines), width);
    const bool legend_fits = picture.width >= legend_from_px;
    picture.height = picture.terrain_height + (legend_fits ? static_cast<std::uint32_t>(legend.height()) : 0);
    picture.rgb.resize(std::size_t{picture.width} * picture.height * 3);

    parallel_for(height, threads, [&](std::int64_t row) {
        const auto y = static_cast<std::int32_t>(row);
        fill(picture, {0, y, width, 1}, [&](std::int32_t x, std::int32_t) {
            const std::int32_t i = share(x, cells.columns, width), j = share(y, cells.rows, height);
            const std::size_t at = cells.index(i, j);
            const Rgb8 ground = cells.hole[at] ? hole_rgb : lit(relief.brightness(i, j), ramp.tint(cells.error_m[at]));
            const bool line = lines.columns[static_cast<std::size_t>(x)] || lines.rows[static_cast<std::size_t>(y)];
            return line ? lined(ground) : ground;
        });
    });
    if (legend_fits) legend.draw(picture, height);
    return picture;
}

void write_png(const Picture& picture, io::AtomicFile& file) {
    std::vector<std::uint8_t> png;
    const auto append = [](void* to, void* bytes, int count) {
        const auto* first = static_cast<const std::uint8_t*>(bytes);
        auto& out = *static_cast<std::vector<std::uint8_t>*>(to);
        out.insert(out.end(), first, first + count);
    };
    if (!stbi_write_png_to_func(append, &png, static_cast<int>(picture.width), static_cast<int>(picture.height), 3,
                                picture.rgb.data(), static_cast<int>(picture.width * 3)))
        throw io::Failure(3, "out of memory for the picture; ask for a smaller one (--picture-size)");
    file.write(std::as_bytes(std::span(png)));
    file.commit();
}

} // namespace fjell::baker
