#include "editor/jobs/rules_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "baker/maps/control.h"
#include "baker/maps/wetness.h"
#include "baker/read/source.h"

namespace fjell::editor {

namespace {

// What people expect of these names; any other material takes the next of colours that colour-blind people tell apart
// (M. Okabe and K. Ito, 2008).
struct KnownColour {
    const char* name;
    gl::Rgb8 rgb;
};
constexpr KnownColour known_colours[] = {
    {"grass", {96, 132, 62}}, {"dry_grass", {176, 158, 96}}, {"forest_floor", {52, 84, 48}},
    {"soil", {122, 88, 58}},  {"gravel", {158, 146, 128}},   {"scree", {128, 120, 112}},
    {"rock", {92, 90, 92}},   {"snow", {236, 240, 246}},     {"sand", {214, 188, 140}},
    {"ice", {178, 206, 226}}, {"water", {40, 96, 160}}};
constexpr gl::Rgb8 other_colours[] = {{230, 159, 0}, {86, 180, 233}, {0, 158, 115},  {240, 228, 66},
                                      {0, 114, 178}, {213, 94, 0},   {204, 121, 167}};

gl::Rgb8 colour_of(const std::string& name, std::size_t& others) {
    for (const KnownColour& known : known_colours)
        if (name == known.name) return known.rgb;
    return other_colours[others++ % std::size(other_colours)];
}

// Holes get the lowest height: rules want numbers, and nothing is shown there.
std::vector<float> filled(const std::vector<float>& heights_m) {
    float least = 0;
    bool any = false;
    for (const float h : heights_m)
        if (!std::isnan(h)) least = any ? std::min(least, h) : h, any = true;
    std::vector<float> all = heights_m;
    for (float& h : all)
        if (std::isnan(h)) h = least;
    return all;
}

std::vector<float> part_of(const std::vector<float>& all, std::int32_t row_cells, const baker::Window& part) {
    std::vector<float> heights;
    heights.reserve(part.area());
    for (std::int32_t y = part.y; y < part.y + part.rows; ++y) {
        const auto row = all.begin() + std::ptrdiff_t{y} * row_cells + part.x;
        heights.insert(heights.end(), row, row + part.columns);
    }
    return heights;
}

} // namespace

RulesLook look_at_rules(const std::string& path, const baker::HeightSource& source, std::uint32_t cells_x,
                        std::uint32_t cells_y, const std::vector<float>& heights_m) {
    const baker::ControlPlan plan = baker::read_control(path);
    const std::vector<float> all = filled(heights_m);
    baker::ControlGround ground{
        static_cast<std::int32_t>(cells_x), static_cast<std::int32_t>(cells_y), {1, 1}, 0, nullptr};
    baker::Frame frame = baker::frame_of(source);
    const double wide[2] = {source.columns / static_cast<double>(cells_x), source.rows / static_cast<double>(cells_y)};
    frame.columns = ground.columns;
    frame.rows = ground.rows;
    for (std::size_t k = 0; k < 2; ++k) {
        ground.spacing_m[k] = source.spacing_m[k] * wide[k];
        frame.origin[k] += frame.step[k] * (wide[k] - 1) / 2; // a cell's middle
        frame.step[k] *= wide[k];
    }
    std::optional<baker::Wetness> wetness;
    if (plan.wants_wetness()) {
        wetness.emplace(baker::wetness_grid(ground.columns, ground.rows, ground.spacing_m), all);
        ground.wetness = &*wetness;
    }
    const baker::ControlImages images = baker::open_control_images(plan, frame);
    baker::ControlReaders readers;
    for (const auto& image : images) readers.push_back(image->reader());
    const baker::Window points{0, 0, ground.columns, ground.rows};
    const std::vector<float> seen = part_of(all, ground.columns, baker::heights_for_control(ground, points));
    const baker::TexelPlanes shares = baker::control_shares(plan, ground, points, {seen.data(), images, readers});

    RulesLook look;
    look.rules = plan.rules.size();
    std::size_t others = 0;
    for (const std::string& name : plan.names) look.layers.push_back({name, 0, colour_of(name, others)});
    look.covered.resize(points.area());
    look.colour.resize(points.area());
    double cells = 0;
    for (std::size_t i = 0; i < points.area(); ++i) {
        if (std::isnan(heights_m[i])) continue;
        std::array<double, 3> sum{};
        double covered = 0;
        for (std::size_t n = 0; n < look.layers.size(); ++n) {
            const auto share = static_cast<double>(shares.channel[n][i]);
            covered += share;
            look.layers[n].share += share;
            for (std::size_t k = 0; k < 3; ++k) sum[k] += share * look.layers[n].rgb[k];
        }
        cells += 1;
        look.bare_share += 1 - std::min(covered, 1.0);
        look.covered[i] = static_cast<float>(std::min(covered, 1.0));
        for (std::size_t k = 0; k < 3 && covered > 0; ++k)
            look.colour[i] |= static_cast<std::uint32_t>(std::clamp(sum[k] / covered, 0.0, 255.0)) << (8 * k);
    }
    for (RuleLayer& layer : look.layers) layer.share /= std::max(cells, 1.0);
    look.bare_share /= std::max(cells, 1.0);
    return look;
}

} // namespace fjell::editor
