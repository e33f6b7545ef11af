// What an experiment has shown, in sentences whose every number is measured, and whose every comparison is computed.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "lab/results.h"

namespace fjell::lab {

namespace {

// The least and the largest of some ratios.
struct Range {
    double low = std::numeric_limits<double>::max(), high = 0;
    std::size_t count = 0, below_one = 0;
    void take(double v) {
        low = std::min(low, v);
        high = std::max(high, v);
        ++count;
        below_one += v < 1;
    }
    [[nodiscard]] std::string text() const {
        const std::string a = fmt::format("{:.2f}", low), b = fmt::format("{:.2f}", high);
        return a == b ? a : a + " to " + b;
    }
};

// The result that differs from this one as `change` says.
const Result* twin(const Results& results, const Result& of, const std::function<void(Case&)>& change) {
    Case wanted = of.c;
    change(wanted);
    if (wanted.way == Way::lean) wanted.tile_cells = 0, wanted.order = results.recipe.orders[0];
    const nlohmann::json fields = wanted.json();
    for (const Result& r : results.all)
        if (r.c.json() == fields && !r.measured.empty()) return &r;
    return nullptr;
}

// Twin's measure over one's own, for all results that `of` picks and that have one.
Range ratios(const Results& results, const char* measure, const std::function<bool(const Case&)>& of,
             const std::function<void(Case&)>& change) {
    Range range;
    for (const Result& r : results.all) {
        const auto own = r.value(measure);
        if (!own || *own <= 0 || !of(r.c)) continue;
        const Result* const other = twin(results, r, change);
        if (other && other->value(measure)) range.take(*other->value(measure) / *own);
    }
    return range;
}

bool recursive(const Case& c) {
    return c.way == Way::recursive;
}

// Ours over theirs, at thresholds that both have.
Range over_published(const Results& results, const Published& theirs, int tile_cells) {
    Range range;
    for (const Result& r : results.all)
        for (std::size_t i = 0; i < theirs.thresholds_px.size(); ++i)
            if (recursive(r.c) && r.c.tile_cells == tile_cells && r.c.error_px == theirs.thresholds_px[i] &&
                r.value("vertices"))
                range.take(*r.value("vertices") / theirs.vertices[i]);
    return range;
}

std::string on_tilings(const Results& results) {
    std::string text;
    const int first = results.recipe.tile_cells.front(), last = results.recipe.tile_cells.back();
    const auto of_first = [&](const Case& c) { return recursive(c) && c.tile_cells == first; };
    const auto to_last = [&](Case& c) { c.tile_cells = last; };
    if (const Range v = ratios(results, "vertices", of_first, to_last); v.count)
        text += fmt::format("The recursive method selects {} times as many vertices with tiles of {} cells as with "
                            "{}, and its median update takes {} times as long, over all thresholds. ",
                            v.text(), last, first, ratios(results, "median_us", of_first, to_last).text());
    const Range incremental = ratios(results, "median_us", recursive, [](Case& c) { c.way = Way::incremental; });
    double speed = 0;
    for (const Result& r : results.all) speed = r.value("flown_cells_a_frame").value_or(speed); // one path for all
    if (incremental.count)
        text += fmt::format("The camera flies {:.1f} cells a frame on average; there the incremental method's median "
                            "takes {} times the recursive one's, and is the shorter in {} of {} cases. ",
                            speed, incremental.text(), incremental.below_one, incremental.count);
    const Range lean = ratios(results, "median_us", recursive, [](Case& c) { c.way = Way::lean; });
    if (lean.count) text += fmt::format("The leanest recursion takes {} times the recursive method's. ", lean.text());
    if (!results.published.empty() && !results.recipe.site.file.empty())
        if (const Range v = over_published(results, results.published.front(), first); v.count)
            text += fmt::format(
                "Our recursive method selects {} times the vertices of the thesis' table {}, along another path. ",
                v.text(), results.published.front().name);
    return text;
}

// "1.00 / 2.00 / 3.00", for a sentence that names what they are of in the same order.
std::string listed(const std::vector<Range>& ranges) {
    std::string text;
    for (const Range& r : ranges) text += (text.empty() ? "" : " / ") + (r.count ? r.text() : "-");
    return text;
}

std::string on_orders(const Results& results) {
    std::vector<Range> times[2], memory[2], pages[2], misses[2]; // hierarchical Z, linear; for each size of tile
    for (const int tile : results.recipe.tile_cells)
        for (const int i : {0, 1}) {
            const auto of = [&](const Case& c) { return c.tile_cells == tile && c.order == PageOrder::planar; };
            const auto to = [&](Case& c) { c.order = i == 0 ? PageOrder::hierarchical_z : PageOrder::linear; };
            times[i].push_back(ratios(results, "median_us", of, to));
            memory[i].push_back(ratios(results, "memory_pages", of, to));
            pages[i].push_back(ratios(results, "pages_read", of, to));
            misses[i].push_back(ratios(results, "memory_misses", of, to));
        }
    if (!std::any_of(times[0].begin(), times[0].end(), [](const Range& r) { return r.count > 0; })) return {};
    return fmt::format(
        "With tiles of {} cells the median update takes {} times planar order's in hierarchical Z-order, "
        "and {} times in linear order. A frame's vertices lie in {} and {} times as many 4 KB of an "
        "array over a whole tile. Of our pages the flight reads {} and {} times as many. With a cache of {:g} MB a "
        "frame "
        "misses {} and {} times as many of the 4 KB. ",
        fmt::join(results.recipe.tile_cells, " / "), listed(times[0]), listed(times[1]), listed(memory[0]),
        listed(memory[1]), listed(pages[0]), listed(pages[1]), results.recipe.cache_mb, listed(misses[0]),
        listed(misses[1]));
}

std::string on_estimates(const Results& results) {
    const auto of = [](const Case& c) { return c.estimate == ErrorEstimate::max; };
    const auto other = [](Case& c) { c.estimate = ErrorEstimate::midpoint; };
    const Range v = ratios(results, "vertices", of, other);
    if (!v.count) return {};
    std::string text = fmt::format("Estimate 2 (mid-point errors) selects {} times the vertices of estimate 1 (true "
                                   "errors), and baking its errors, radii and pages takes {} times as long. ",
                                   v.text(), ratios(results, "bake_s", of, other).text());
    if (const Range popping = ratios(results, "popping_px", of, other); popping.count)
        text += fmt::format("The largest change on screen from one frame to the next is {} times as large. ",
                            popping.text());
    for (const ErrorEstimate e : {ErrorEstimate::max, ErrorEstimate::midpoint}) {
        Range error;
        std::size_t beyond = 0;
        for (const Result& r : results.all)
            if (const auto px = r.value("true_error_px"); px && r.c.estimate == e) {
                error.take(*px / r.c.error_px);
                beyond += *px > r.c.error_px;
            }
        if (error.count)
            text += fmt::format("The true error measured with estimate {} is {} times the threshold, and beyond it in "
                                "{} of {} cases. ",
                                e == ErrorEstimate::max ? 1 : 2, error.text(), beyond, error.count);
    }
    if (results.published.size() == 2) {
        Range theirs;
        for (std::size_t i = 0; i < results.published[0].vertices.size(); ++i)
            theirs.take(results.published[1].vertices[i] / results.published[0].vertices[i]);
        text += fmt::format("In the thesis' tables it is {} times the vertices. ", theirs.text());
    }
    return text;
}

std::string on_methods(const Results& results) {
    const double most = results.recipe.offscreen_factors.back();
    std::vector<Range> median, p99, lean, lean_p99, fewer, shorter;
    for (const double cells : results.recipe.cells_a_frame) {
        const auto of = [&](const Case& c) {
            return c.way == Way::incremental && c.offscreen_factor == 1 && c.cells_a_frame == cells;
        };
        const auto to = [](Way way) { return [way](Case& c) { c.way = way; }; };
        const auto coarser = [&](Case& c) { c.offscreen_factor = most; };
        median.push_back(ratios(results, "median_us", of, to(Way::recursive)));
        p99.push_back(ratios(results, "p99_us", of, to(Way::recursive)));
        lean.push_back(ratios(results, "median_us", of, to(Way::lean)));
        lean_p99.push_back(ratios(results, "p99_us", of, to(Way::lean)));
        fewer.push_back(ratios(results, "vertices", of, coarser));
        shorter.push_back(ratios(results, "median_us", of, coarser));
    }
    if (!std::any_of(median.begin(), median.end(), [](const Range& r) { return r.count > 0; })) return {};
    std::string text = fmt::format(
        "At {} cells a frame our recursive method's median takes {} times the incremental one's and its p99 {} times, "
        "the leanest recursion's median {} times and its p99 {} times. ",
        fmt::join(results.recipe.cells_a_frame, " / "), listed(median), listed(p99), listed(lean), listed(lean_p99));
    if (most > 1)
        text += fmt::format("With an offscreen factor of {:g} the incremental method holds {} times the vertices and "
                            "its median takes {} times as long. ",
                            most, listed(fewer), listed(shorter));
    std::size_t measured = 0, within = 0;
    for (const Result& r : results.all)
        if (const auto px = r.value("true_error_px")) {
            ++measured;
            within += *px <= r.c.error_px;
        }
    if (measured)
        text += fmt::format("The true error measured is within the threshold in {} of {} cases. ", within, measured);
    return text;
}

// The median of one over that of another, at each speed.
std::vector<Range> over(const Results& results, const char* measure, Way of, Way to) {
    std::vector<Range> all;
    for (const double cells : results.recipe.cells_a_frame)
        all.push_back(ratios(
            results, measure, [&](const Case& c) { return c.way == of && c.cells_a_frame == cells; },
            [&](Case& c) {
                c.way = to;
                c.tile_cells = results.recipe.tile_cells[0]; // the leanest recursion has none
            }));
    return all;
}

std::string on_rivals(const Results& results) {
    const Result* ours = nullptr;
    for (const Result& r : results.all)
        if (r.c.way == Way::incremental && r.value("equal_triangles")) ours = &r;
    if (!ours) return {};
    std::string most = "At equal true error", cracked, beyond;
    for (const Result& r : results.all) {
        if (!r.value("true_error_px")) continue;
        const std::string name = r.c.json().at("method");
        if (r.value("open_edges").value_or(0) > 0) cracked += (cracked.empty() ? "" : ", ") + name;
        if (*r.value("true_error_px") > r.c.error_px)
            beyond += fmt::format("{}{} ({:.1f} times)", beyond.empty() ? "" : ", ", name,
                                  *r.value("true_error_px") / r.c.error_px);
        if (const auto equal = r.value("equal_triangles"); equal && r.c.way != Way::incremental)
            most += fmt::format("{} {} takes {:.2f}", most.ends_with("error") ? "" : ",", name,
                                *equal / *ours->value("equal_triangles"));
    }
    most += " times the triangles of our incremental method. ";
    const std::string speeds = fmt::format("{}", fmt::join(results.recipe.cells_a_frame, " / "));
    return most +
           fmt::format("The true error goes beyond the threshold with {}. There are cracks with {}. ",
                       beyond.empty() ? "none" : beyond, cracked.empty() ? "none" : cracked) +
           fmt::format("At {} cells a frame ROAM's median takes {} times ours, nested error spheres {}, the leanest "
                       "recursion {}, a binary tree {}. ",
                       speeds, listed(over(results, "median_us", Way::incremental, Way::roam)),
                       listed(over(results, "median_us", Way::incremental, Way::spheres)),
                       listed(over(results, "median_us", Way::incremental, Way::lean)),
                       listed(over(results, "median_us", Way::incremental, Way::binary_tree)));
}

std::string on_drawing(const Results& results) {
    const Recipe& r = results.recipe;
    const int coarse = r.texture_cells.front(), fine = r.texture_cells.back();
    const int first = r.tile_cells.front(), last = r.tile_cells.back();
    const auto any = [](const Case&) { return true; };
    std::string text;
    if (const Range v = ratios(
            results, "frame_work_ms", [&](const Case& c) { return c.texture_cells == coarse; },
            [&](Case& c) { c.texture_cells = fine; });
        v.count && coarse != fine)
        text += fmt::format("A whole frame works {} times as long with {} cells a texel as with {}. ", v.text(), fine,
                            coarse);
    if (const Range v = ratios(
            results, "frame_work_ms", [&](const Case& c) { return c.tile_cells == first; },
            [&](Case& c) { c.tile_cells = last; });
        v.count && first != last)
        text += fmt::format("With tiles of {} cells it works {} times as long as with {}. ", last, v.text(), first);
    const auto least = *std::min_element(r.thresholds_px.begin(), r.thresholds_px.end()),
               most = *std::max_element(r.thresholds_px.begin(), r.thresholds_px.end());
    if (const Range v = ratios(results, "frame_work_ms", any, [&](Case& c) { c.error_px = least; }); v.count)
        text += fmt::format("From {} px to {} px its work grows at most {:.2f} times. ", most, least, v.high);
    Range coarsest, finest;
    for (const Result& each : results.all)
        if (const auto d = each.value("image_difference")) {
            if (each.c.error_px == most) coarsest.take(*d);
            if (each.c.error_px == least) finest.take(*d);
        }
    if (coarsest.count && finest.count)
        text += fmt::format("Pictures differ from the finest mesh's by {} levels of 255 at {} px, and by {} at {} px. ",
                            coarsest.text(), most, finest.text(), least);
    return text;
}

std::string on_instructions(const Results& results) {
    std::string text;
    for (const Way way : results.recipe.ways) {
        const auto each = over(results, "instructions", Way::lean, way);
        const bool any = std::any_of(each.begin(), each.end(), [](const Range& range) { return range.count > 0; });
        if (way == Way::lean || !any) continue;
        Case c;
        c.way = way;
        text +=
            fmt::format("{} {} {}", text.empty() ? "" : ",", c.json().at("method").get<std::string>(), listed(each));
    }
    if (text.empty()) return {};
    return fmt::format("At {} cells a frame an update takes, in instructions and times the leanest recursion's:{}. ",
                       fmt::join(results.recipe.cells_a_frame, " / "), text);
}

} // namespace

std::string conclusion_of(const Results& results) {
    const std::string& kind = results.recipe.conclusion;
    std::string text = kind == "tilings"        ? on_tilings(results)
                       : kind == "orders"       ? on_orders(results)
                       : kind == "estimates"    ? on_estimates(results)
                       : kind == "rivals"       ? on_rivals(results)
                       : kind == "drawing"      ? on_drawing(results)
                       : kind == "instructions" ? on_instructions(results)
                                                : on_methods(results);
    if (text.empty()) return "Too few cases are measured to say anything.";
    text.pop_back();
    return text;
}

} // namespace fjell::lab
