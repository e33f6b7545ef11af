#include "baker/read/void_check.h"

#include <fmt/format.h>

#include "fjell/pack.h"

namespace fjell::baker {

void refuse_voids(const ReadStatistics& statistics, const VoidCheck& check) {
    constexpr const char* remedy =
        "give --nodata hole to leave them open or --nodata fill to fill them from their neighbours";
    const auto& voids = statistics.voids;
    const auto& implausible = statistics.implausible;
    if (!(statistics.least_m <= statistics.most_m)) {
        std::string text =
            fmt::format("{}: all {} samples are no-data, NaN or outside {}..{} m; give a file with heights",
                        check.names, check.samples, lowest_m, highest_m);
        if (implausible.count)
            text += fmt::format(", or if such as {} m are heights: --zscale S for another unit, --zoffset M if they "
                                "count from elsewhere, --void none if they are right",
                                statistics.implausible_m);
        throw Failure(1, text);
    }
    if (implausible.count && (check.nodata == NoData::automatic || check.nodata == NoData::refuse))
        throw Failure(1, fmt::format("{}: {} of {} heights lie outside {}..{} m, the first {} m at column {}, row {}; "
                                     "if they are voids, {}; if the unit is another, give --zscale S",
                                     check.names, implausible.count, check.samples, lowest_m, highest_m,
                                     statistics.implausible_m, implausible.column, implausible.row, remedy));
    if (voids.count && check.nodata == NoData::refuse && !check.warped)
        throw Failure(1, fmt::format("{}: {} of {} samples are no-data or NaN, the first at column {}, row {}; {}",
                                     check.names, voids.count, check.samples, voids.column, voids.row, remedy));
    // Squares of heights must stay far from float's largest value, like those of extents.
    if (statistics.least_m < -max_extent_m || statistics.most_m > max_extent_m)
        throw Failure(2, fmt::format("{}: heights become {}..{} m; give a smaller --zscale", check.names,
                                     statistics.least_m, statistics.most_m));
}

void tell_voids(const VoidFindings& found, const VoidCheck& check, SourceProperties& properties) {
    if (!found.voids.empty()) {
        std::string what, options;
        for (const NumberTally& v : found.voids) {
            what += fmt::format("{}{} of {} heights are {}, the first at column {}, row {}", what.empty() ? "" : ", ",
                                v.samples.count, found.samples, number_text(v.number), v.samples.column, v.samples.row);
            options += fmt::format(" --void {}", number_text(v.number));
        }
        const std::string others = found.others ? fmt::format("; all others lie from {} to {}",
                                                              number_text(found.least), number_text(found.most))
                                                : "";
        throw Failure(1, fmt::format("{}: {}{}{}; if they are voids, give{} (they become holes, or are filled with "
                                     "--nodata fill); if they are ground, --void none",
                                     check.names, what, others,
                                     check.scaling == Scaling{} ? "" : " (numbers as the file has them)", options));
    }
    for (const Repeated& r : found.repeated)
        (r.lowest ? properties.lowest
                  : properties.highest) = {r.at.number, check.scaling.asked_m(check.scaling.file_m(r.at.number)),
                                           static_cast<double>(r.at.samples.count) / static_cast<double>(found.samples),
                                           r.at.samples.column, r.at.samples.row};
}

} // namespace fjell::baker
