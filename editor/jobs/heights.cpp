#include "editor/jobs/heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <regex>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "baker/bake/inputs.h"
#include "baker/georeference/crs_label.h"
#include "baker/georeference/open_source.h"
#include "baker/maps/colour.h"
#include "baker/maps/image.h"
#include "baker/maps/splat.h"
#include "baker/maps/wetness.h"
#include "baker/read/gdal_file.h"
#include "baker/read/source.h"
#include "editor/jobs/work.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

using io::Failure;
namespace fs = std::filesystem;

constexpr std::uint32_t picture_columns = 240, picture_rows = 150;
constexpr double most_read = 6e6;   // samples, all of which are read
constexpr double mean_slope = 0.18; // of mountains, between samples: what an unknown spacing is proposed by
constexpr std::size_t read_at_once = 1u << 20;

// Messages of the baker name options of fjell-bake; the dialog has fields. The option that is named first is the one
// that is missing.
struct OptionWords {
    const char *option, *words;
    BakeField field;
};
constexpr OptionWords option_words[] = {
    {"--spacing M (metres between samples)", "the spacing", BakeField::spacing},
    {"--spacing M", "the spacing", BakeField::spacing},
    {"--spacing", "Spacing", BakeField::spacing},
    {"--nodata hole", "\"hole\" for No data", BakeField::nodata},
    {"--nodata fill", "\"fill\"", BakeField::nodata},
    {"--nodata", "No data", BakeField::nodata},
    {"--void none", "\"none\" for Voids", BakeField::voids},
    {"--void", "Voids", BakeField::voids},
    {"--zscale S", "the height scale", BakeField::height_scale},
    {"--zscale", "Height scale", BakeField::height_scale},
    {"--crs", "CRS", BakeField::crs},
    {"--encoding terrarium or terrain-rgb", "their encoding (More options)", BakeField::encoding},
    {"--encoding", "Encoding", BakeField::encoding},
    {"--vertical-unit", "Height unit", BakeField::vertical_unit},
    {"--bbox", "Extract", BakeField::bbox},
    {"--splat", "Rules", BakeField::rules},
    {"--band N or --band NAME", "its number or name for Band", BakeField::band},
    {"--band", "Band", BakeField::band},
    {"--size COLUMNSxROWS", "their columns and rows for Raw size", BakeField::size},
    {"--size", "Raw size", BakeField::size},
    {"--texture-bands N", "its number for Texture bands", BakeField::texture_bands},
    {"--texture-bands R,G,B", "Texture bands, such as 4,3,2", BakeField::texture_bands},
    {"--texture-bands", "Texture bands", BakeField::texture_bands},
};

// The number behind the first --void, or the word behind --nodata.
std::string proposal_of(const std::string& message, BakeField field) {
    if (field == BakeField::nodata) return "hole";
    if (field != BakeField::voids) return {};
    std::smatch found;
    return std::regex_search(message, found, std::regex("--void (-?[0-9.]+)")) ? found[1].str() : std::string();
}

void tell_problem(HeightFacts& f, std::string message, BakeField otherwise) {
    if (!f.problem.empty()) return; // one at a time, the first first
    std::size_t first = std::string::npos;
    f.at = otherwise;
    for (const OptionWords& o : option_words)
        if (const std::size_t at = message.find(o.option); at < first) {
            first = at;
            f.at = o.field;
        }
    f.proposed = proposal_of(message, f.at);
    for (const OptionWords& o : option_words)
        for (std::size_t at; (at = message.find(o.option)) != std::string::npos;)
            message.replace(at, std::string(o.option).size(), o.words);
    f.problem = std::move(message);
}

// Round, so that nobody takes it for measured.
double rounded(double value) {
    const double decade = std::pow(10, std::floor(std::log10(value)));
    for (const double step : {1.0, 2.0, 3.0, 5.0, 10.0})
        if (value <= 1.2 * step * decade) return step * decade;
    return 10 * decade;
}

// Many files say it in their names: canyon_60m_4097.png.
double spacing_in_name(const std::string& path) {
    const std::string name = fs::path(path).stem().string();
    std::smatch found;
    static const std::regex metres("(^|[^A-Za-z0-9])([0-9]+(\\.[0-9]+)?) ?m($|[^A-Za-z0-9])");
    if (!std::regex_search(name, found, metres)) return 0;
    const double value = std::stod(found[2].str());
    return value > 0 && value < 1e5 ? value : 0;
}

void propose_spacing(HeightFacts& f, const BakePack& pack, double mean_step_m) {
    if (const double named = spacing_in_name(pack.inputs.front()); named > 0) {
        f.proposed = fmt::format("{:g}", named);
        f.because = "as the file's name says";
    } else if (mean_step_m > 0) {
        f.proposed = fmt::format("{:g}", rounded(mean_step_m / mean_slope));
        f.because = "with which slopes are those of mountains; change it if you know better";
    }
}

// What was read, small: means of the samples of each texel, NaN where there is none.
struct SmallField {
    std::uint32_t columns = 0, rows = 0;
    std::vector<float> heights_m;
    double steps_m = 0; // between neighbours in a row, added up
    std::uint64_t step_count = 0;
};

// times: as many texels, each way, as the picture has.
SmallField small_field_of(std::int32_t columns, std::int32_t rows, double times = 1) {
    SmallField f;
    const double scale = std::min({1.0, times * picture_columns / columns, times * picture_rows / rows});
    f.columns = std::max(static_cast<std::uint32_t>(std::lround(columns * scale)), 1u);
    f.rows = std::max(static_cast<std::uint32_t>(std::lround(rows * scale)), 1u);
    f.heights_m.assign(std::size_t{f.columns} * f.rows, std::numeric_limits<float>::quiet_NaN());
    return f;
}

// Rows of a window, all of which belong to one row of the small field.
void add_rows(SmallField& f, std::uint32_t row, std::span<const float> heights, std::size_t columns,
              std::vector<double>& sums, std::vector<std::uint32_t>& counts) {
    for (std::size_t from = 0; from < heights.size(); from += columns)
        for (std::size_t c = 0; c < columns; ++c) {
            const float h = heights[from + c];
            if (std::isnan(h)) continue;
            const std::size_t at = c * f.columns / columns;
            sums[at] += static_cast<double>(h);
            ++counts[at];
            if (c > 0 && !std::isnan(heights[from + c - 1])) {
                f.steps_m += std::abs(static_cast<double>(h - heights[from + c - 1]));
                ++f.step_count;
            }
        }
    for (std::size_t c = 0; c < f.columns; ++c)
        if (counts[c] != 0) f.heights_m[std::size_t{row} * f.columns + c] = static_cast<float>(sums[c] / counts[c]);
}

// False: it was told to stop.
bool read_small(const baker::HeightSource& s, const baker::Window& part, SmallField& f,
                baker::ReadStatistics& statistics, bool all, const std::atomic<bool>& stop,
                std::atomic<double>* share) {
    const auto reader = s.reader();
    const auto columns = static_cast<std::size_t>(part.columns);
    const auto most_rows = static_cast<std::int32_t>(std::max<std::size_t>(read_at_once / columns, 1));
    std::vector<float> heights;
    std::vector<double> sums(f.columns);
    std::vector<std::uint32_t> counts(f.columns);
    for (std::uint32_t row = 0; row < f.rows; ++row) {
        if (share != nullptr) share->store(row / static_cast<double>(f.rows), std::memory_order_relaxed);
        const auto at = [&](std::uint32_t r) {
            return static_cast<std::int32_t>(std::int64_t{r} * part.rows / f.rows);
        };
        std::int32_t begin = at(row), end = at(row + 1);
        if (!all) {
            begin = (begin + end) / 2;
            end = begin + 1;
        }
        std::ranges::fill(sums, 0.0);
        std::ranges::fill(counts, 0u);
        for (std::int32_t y = begin; y < end; y += most_rows) {
            if (stop.load(std::memory_order_relaxed)) return false;
            const std::int32_t n = std::min(most_rows, end - y);
            heights.resize(columns * static_cast<std::size_t>(n));
            reader->read({part.x, part.y + y, part.columns, n}, heights.data(), statistics);
            add_rows(f, row, heights, columns, sums, counts);
        }
    }
    return true;
}

// Where the samples of a reprojected field come from: of each cell of a small one its place in the files, NaN where no
// file reaches, and the part of the files that it takes.
struct SourcePlaces {
    std::vector<std::array<double, 2>> of_cell;
    baker::Window part;
};

SourcePlaces places_of(const baker::Unwarped& files, const baker::HeightSource& to, const SmallField& f) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    SourcePlaces p;
    double least[2] = {infinite, infinite}, most[2] = {-infinite, -infinite};
    const double extent[2] = {files.source->columns - 0.5, files.source->rows - 0.5};
    for (std::uint32_t y = 0; y < f.rows; ++y)
        for (std::uint32_t x = 0; x < f.columns; ++x) {
            std::array<double, 2> at{(x + 0.5) * to.columns / f.columns - 0.5, (y + 0.5) * to.rows / f.rows - 0.5};
            const bool there =
                files.place(at[0], at[1]) && at[0] >= -0.5 && at[1] >= -0.5 && at[0] < extent[0] && at[1] < extent[1];
            if (!there) at[0] = std::numeric_limits<double>::quiet_NaN();
            p.of_cell.push_back(at);
            for (std::size_t axis = 0; axis < 2 && there; ++axis) {
                least[axis] = std::min(least[axis], at[axis]);
                most[axis] = std::max(most[axis], at[axis]);
            }
        }
    if (!(least[0] <= most[0])) return p;
    const auto whole = [](double place) { return static_cast<std::int32_t>(std::lround(place)); };
    p.part = {whole(least[0]), whole(least[1]), whole(most[0]) - whole(least[0]) + 1,
              whole(most[1]) - whole(least[1]) + 1};
    return p;
}

// As the bake will lay it out, from what was read of the files: the nearest cell of each place.
void reproject(const SmallField& from, const SourcePlaces& places, SmallField& f) {
    for (std::size_t i = 0; i < places.of_cell.size(); ++i) {
        const auto [column, row] = places.of_cell[i];
        if (std::isnan(column)) continue;
        const auto cell = [](double at, std::int32_t first, std::int32_t count, std::uint32_t cells) {
            const auto c = static_cast<std::int64_t>((std::round(at) - first) * cells / count);
            return static_cast<std::size_t>(std::clamp<std::int64_t>(c, 0, std::int64_t{cells} - 1));
        };
        f.heights_m[i] = from.heights_m[cell(row, places.part.y, places.part.rows, from.rows) * from.columns +
                                        cell(column, places.part.x, places.part.columns, from.columns)];
    }
}

std::uint32_t packed_rgb(const float (&rgb)[3], float light) {
    std::uint32_t value = 0xff000000u;
    for (std::size_t k = 0; k < 3; ++k)
        value |= static_cast<std::uint32_t>(std::clamp(rgb[k] * light, 0.0F, 255.0F)) << (8 * k);
    return value;
}

// In the colours that the bake would give it, lit from the north-west. That light.
std::vector<float> paint(HeightFacts& f, const SmallField& small, const std::string& ramp_path, double cell_m) {
    const double least = f.least_m, most = std::max(f.most_m, f.least_m + 1e-3);
    const baker::Ramp ramp = baker::absolute(
        ramp_path.empty() ? baker::default_ramp(least, most) : baker::read_ramp(ramp_path), least, most);
    baker::RampPainter painter(ramp);
    float rgb[3];
    for (std::size_t i = 0; i < ramp_strip; ++i) {
        painter.paint(static_cast<float>(least + (most - least) * static_cast<double>(i) / (ramp_strip - 1)), 1, rgb);
        for (std::size_t k = 0; k < 3; ++k) f.strip[i][k] = static_cast<std::uint8_t>(std::clamp(rgb[k], 0.0F, 255.0F));
    }
    // Steeper than it is where texels are wide, or relief would not show.
    const float exaggerated = 3 / static_cast<float>(std::max(cell_m, 1e-6));
    std::vector<float> light(small.heights_m.size());
    for (std::uint32_t y = 0; y < small.rows; ++y)
        for (std::uint32_t x = 0; x < small.columns; ++x) {
            const auto height = [&](std::uint32_t column, std::uint32_t row) {
                return small.heights_m[std::size_t{row} * small.columns + column];
            };
            const float h = height(x, y);
            std::uint32_t& texel = f.texels[std::size_t{y} * f.width_px + x];
            texel = 0xff2a2520u; // a hole: the panels' grey
            if (std::isnan(h)) continue;
            const auto rise = [&](float from) { return std::isnan(from) ? 0.0F : (h - from) * exaggerated; };
            const float dx = x > 0 ? rise(height(x - 1, y)) : 0, dz = y > 0 ? rise(height(x, y - 1)) : 0;
            const float steep = std::sqrt(dx * dx + dz * dz + 1);
            painter.paint(h, 1, rgb);
            float& lit = light[std::size_t{y} * small.columns + x];
            lit = 0.4F + 0.85F * std::clamp((0.5F * (dx + dz) + 0.71F) / steep, 0.0F, 1.0F);
            texel = packed_rgb(rgb, lit);
        }
    return light;
}

// Numbers of the three bands, in turn, as the bake shows them: by a palette, or the whitest of 16 bits as white.
std::vector<std::uint8_t> bytes_of(const std::vector<std::uint16_t>& numbers, GDALRasterBand& band) {
    std::vector<std::uint8_t> bytes(numbers.size());
    const GDALColorTable* const table = band.GetColorTable();
    const std::uint32_t white =
        band.GetRasterDataType() == GDT_Byte ? 255 : baker::picture_white(band, *std::ranges::max_element(numbers));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (!table) {
            bytes[i] =
                static_cast<std::uint8_t>((std::min<std::uint32_t>(numbers[i], white) * 255 + white / 2) / white);
        } else if (const GDALColorEntry* const c = table->GetColorEntry(numbers[i])) {
            bytes[i] = static_cast<std::uint8_t>(i % 3 == 0 ? c->c1 : i % 3 == 1 ? c->c2 : c->c3);
        }
    }
    return bytes;
}

// To the right of the heights, as high as they are.
void add_image(HeightFacts& f, const std::string& path, const std::string& texture_bands, std::uint32_t rows) {
    baker::GdalMessages messages;
    baker::register_drivers();
    const baker::GdalFile file = baker::open_raster(path, "an image", messages);
    const int w = file->GetRasterXSize(), h = file->GetRasterYSize();
    std::vector<int> bands = baker::picture_bands(*file, texture_bands, path);
    if (bands.empty()) bands = file->GetRasterCount() >= 3 ? std::vector{1, 2, 3} : std::vector{1};
    f.image = fmt::format("{} x {} pixels, {}", w, h, bands.size() == 3 ? "colour" : "grey");
    const double scale = std::min(rows / static_cast<double>(h), picture_columns / static_cast<double>(w));
    f.image_px = std::max(static_cast<std::uint32_t>(w * scale), 1u);
    const std::uint32_t high = std::max(static_cast<std::uint32_t>(h * scale), 1u);
    std::vector<std::uint16_t> numbers(std::size_t{3} * f.image_px * high);
    for (std::size_t band = 0; band < 3; ++band)
        if (file->GetRasterBand(bands[band % bands.size()])
                ->RasterIO(GF_Read, 0, 0, w, h, numbers.data() + band, static_cast<int>(f.image_px),
                           static_cast<int>(high), GDT_UInt16, 6, 6 * static_cast<GSpacing>(f.image_px),
                           nullptr) != CE_None)
            throw Failure(1, fmt::format("{}: cannot be read{}", path, messages.said()));
    const std::vector<std::uint8_t> rgb = bytes_of(numbers, *file->GetRasterBand(bands[0]));
    const std::uint32_t before = f.width_px;
    std::vector<std::uint32_t> both(std::size_t{before + f.image_px} * f.height_px, 0xff2a2520u);
    for (std::uint32_t y = 0; y < f.height_px; ++y) {
        std::copy_n(f.texels.begin() + std::ptrdiff_t{y} * before, before,
                    both.begin() + std::ptrdiff_t{y} * (before + f.image_px));
        for (std::uint32_t x = 0; y < high && x < f.image_px; ++x) {
            const std::uint8_t* const c = rgb.data() + 3 * (std::size_t{y} * f.image_px + x);
            both[std::size_t{y} * (before + f.image_px) + before + x] =
                0xff000000u | c[0] | std::uint32_t{c[1]} << 8 | std::uint32_t{c[2]} << 16;
        }
    }
    f.texels = std::move(both);
    f.width_px = before + f.image_px;
}

// In the colours of their layers, as far as rules cover the ground, under the light that is there already.
void lay_rules(HeightFacts& f, const BakePack& pack, const baker::HeightSource& source, const SmallField& small,
               const std::vector<float>& light) {
    if (pack.rules.empty()) return;
    const RulesLook look = look_at_rules(pack.rules, source, small.columns, small.rows, small.heights_m);
    f.rules = look.rules;
    f.layers = look.layers;
    f.bare_share = look.bare_share;
    std::ranges::stable_sort(f.layers, [](const RuleLayer& a, const RuleLayer& b) { return a.share > b.share; });
    for (std::size_t i = 0; i < look.covered.size(); ++i) {
        std::uint32_t& texel = f.texels[i / small.columns * f.width_px + i % small.columns];
        float rgb[3];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto ramp = static_cast<float>(texel >> (8 * k) & 255);
            const auto layer = static_cast<float>(look.colour[i] >> (8 * k) & 255);
            rgb[k] = ramp + look.covered[i] * (layer * light[i] - ramp);
        }
        if (look.covered[i] > 0) texel = packed_rgb(rgb, 1);
    }
}

// As the bake opens it; where it asks for a spacing, with one that serves to look at the heights.
std::unique_ptr<baker::HeightSource> open_to_look(const BakePack& pack, HeightFacts& f) {
    try {
        f.has_spacing = true;
        return baker::open_inputs(bake_recipe(pack));
    } catch (const Failure& failure) {
        tell_problem(f, failure.what(), BakeField::heights);
        if (f.at != BakeField::spacing || pack.spacing_m > 0) return nullptr;
        f.has_spacing = false;
        BakePack with = pack;
        with.spacing_m = 1;
        return baker::open_inputs(bake_recipe(with));
    }
}

void look(const BakePack& pack, HeightFacts& f, const std::atomic<bool>& stop, std::atomic<double>* share) {
    std::error_code ignored;
    for (const std::string& file : pack.inputs)
        if (const auto bytes = fs::file_size(file, ignored); !ignored) f.file_bytes += bytes;
    const auto source = open_to_look(pack, f);
    if (!source) return;
    const baker::HeightSource& s = *source;
    f.columns = static_cast<std::uint32_t>(s.columns);
    f.rows = static_cast<std::uint32_t>(s.rows);
    f.spacing_m[0] = s.spacing_m[0];
    f.spacing_m[1] = s.spacing_m[1];
    f.crs = baker::crs_text(baker::crs_label(s.crs_wkt));
    f.reprojected_from = s.facts.reprojected_from;
    f.unit_named = !s.facts.height_unit.empty() || pack.height_scale != 0;
    // Reprojection interpolates, which takes a look a hundred times as long: it shows the nearest samples.
    const std::optional<baker::Unwarped> files = baker::unwarped(s);
    const baker::HeightSource& from = files ? *files->source : s;
    SourcePlaces places{{}, {0, 0, s.columns, s.rows}};
    SmallField small = small_field_of(s.columns, s.rows);
    if (files) places = places_of(*files, s, small);
    const baker::Window& part = places.part;
    if (part.columns == 0) return;
    f.all_read = static_cast<double>(part.columns) * part.rows <= most_read;
    SmallField read_of = small_field_of(part.columns, part.rows, files ? 2 : 1);
    baker::ReadStatistics statistics;
    if (!read_small(from, part, read_of, statistics, f.all_read, stop, share)) return;
    const double read =
        static_cast<double>(part.columns) * (f.all_read ? part.rows : static_cast<double>(read_of.rows));
    if (files)
        reproject(read_of, places, small);
    else
        small = std::move(read_of);
    f.void_share = static_cast<double>(statistics.voids.count + statistics.implausible.count) / read;
    if (files) // with the corners that no file reaches
        f.void_share =
            static_cast<double>(std::ranges::count_if(small.heights_m, [](float h) { return std::isnan(h); })) /
            static_cast<double>(small.heights_m.size());
    f.known = statistics.least_m <= statistics.most_m;
    f.least_m = static_cast<double>(statistics.least_m);
    f.most_m = static_cast<double>(statistics.most_m);
    if (f.problem.empty()) {
        try {
            (void)from.properties(statistics);
        } catch (const Failure& failure) {
            tell_problem(f, failure.what(), BakeField::heights);
        }
    } else if (f.at == BakeField::spacing && small.step_count != 0) {
        propose_spacing(f, pack, small.steps_m / static_cast<double>(small.step_count));
    }
    if (!f.known) return;
    f.width_px = small.columns;
    f.height_px = small.rows;
    f.texels.resize(std::size_t{f.width_px} * f.height_px);
    // Without a spacing relief is drawn as if it were the one that is proposed.
    const double spacing_m = f.has_spacing ? s.spacing_m[0] : f.proposed.empty() ? 1 : std::stod(f.proposed);
    const double cell_m = spacing_m * s.columns / small.columns;
    std::vector<float> light;
    try {
        light = paint(f, small, pack.ramp, cell_m);
    } catch (const Failure& failure) {
        tell_problem(f, failure.what(), BakeField::ramp);
        light = paint(f, small, "", cell_m);
    }
    try {
        lay_rules(f, pack, s, small, light);
    } catch (const Failure& failure) {
        tell_problem(f, failure.what(), BakeField::rules);
    }
    if (pack.texture.empty()) return;
    try {
        add_image(f, pack.texture, pack.texture_bands, f.height_px);
    } catch (const Failure& failure) {
        tell_problem(f, failure.what(), BakeField::texture);
    }
}

// What the facts depend on.
BakePack looked_at(const BakePack& pack) {
    BakePack p = pack;
    p.output.clear();
    p.tile = 0;
    p.order.clear();
    p.horizons.clear();
    p.splat.clear();
    p.asks = false;
    return p;
}

} // namespace

HeightFacts look_at_heights(const BakePack& pack, const std::atomic<bool>& stop, std::atomic<double>* share) {
    HeightFacts f;
    if (pack.inputs.empty() || pack.inputs.front().empty()) return f;
    try {
        look(pack, f, stop, share);
    } catch (const std::exception& failure) {
        tell_problem(f, failure.what(), BakeField::heights);
    }
    // The field has the whole path.
    std::vector<std::string> named = pack.inputs;
    named.insert(named.end(), {pack.ramp, pack.rules, pack.texture});
    for (const std::string& file : named)
        if (const std::size_t at = f.problem.find(file); !file.empty() && at != std::string::npos)
            f.problem.replace(at, file.size(), fs::path(file).filename().string());
    return f;
}

HeightLook::~HeightLook() {
    if (look_) look_->stop = true;
}

void HeightLook::begin(const BakePack& pack) {
    if (look_) look_->stop = true;
    if (thread_.joinable()) thread_.join(); // within the rows it is at
    look_ = std::make_shared<Look>();
    look_->of = pack;
    thread_ = std::jthread([look = look_] {
        look->facts = look_at_heights(look->of, look->stop, &look->share);
        look->done.store(true, std::memory_order_release);
    });
}

bool HeightLook::follow(BakeDraft& draft) {
    draft.look_share = look_ ? look_->share.load(std::memory_order_relaxed) : 0;
    const bool again = draft.version != version_ || (look_ && look_->stop.load(std::memory_order_relaxed));
    if (BakePack wanted = again ? looked_at(draft.pack) : BakePack{};
        again && (!(wanted == looked_at_) || (look_ && look_->stop))) {
        // One that runs is told to stop first: the frame does not wait for rows that take long.
        if (look_ && !news()) {
            look_->stop = true;
            return false;
        }
        version_ = draft.version;
        looked_at_ = std::move(wanted);
        begin(looked_at_);
        draft.looking = true;
        return true;
    }
    version_ = draft.version;
    if (!news()) return false;
    draft.facts = std::move(look_->facts);
    draft.looking = false;
    ++draft.looks;
    look_.reset();
    return true;
}

// --- What rules would lay.

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
    const baker::SplatPlan plan = baker::read_splat(path);
    const std::vector<float> all = filled(heights_m);
    baker::SplatGround ground{
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
    const baker::SplatImages images = baker::open_splat_images(plan, frame);
    baker::SplatReaders readers;
    for (const auto& image : images) readers.push_back(image->reader());
    const baker::Window points{0, 0, ground.columns, ground.rows};
    const std::vector<float> seen = part_of(all, ground.columns, baker::heights_for_splat(ground, points));
    const baker::TexelPlanes shares = baker::splat_shares(plan, ground, points, {seen.data(), images, readers});

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
