// Profiles: any text is refused, naming the file, or gives settings within their ranges, which can be written and read.
#include <cstdint>
#include <cstring>
#include <string_view>

#include "fjell/io/failure.h"
#include "fjell/profile/keys.h"
#include "input.h"

using namespace fjell;
using fuzz::must;

extern "C" int fuzz_profile(const std::uint8_t* data, std::size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    try {
        const Profile p = parse_profile(text, "fuzz");
        must(p.refine.max_error_px >= ranges::least_threshold_px && p.refine.max_error_px <= ranges::most_threshold_px,
             "error_px keeps to its range");
        must(p.cut.hysteresis >= 0 && p.cut.hysteresis <= ranges::max_hysteresis, "hysteresis keeps to its range");
        must(p.cut.offscreen_factor >= 1 && p.cut.offscreen_factor <= max_offscreen_factor,
             "offscreen_factor keeps to its range");
        must(p.cut.morph_s >= ranges::min_morph_s && p.cut.morph_s <= ranges::max_morph_s,
             "morph_s keeps to its range");
        must(p.cut.max_time_us >= 0 && p.cut.max_time_us <= ranges::most_time_us, "budget_us keeps to its range");
        must(p.cut.max_work > 0, "no items means all");
        must(p.cut_budget.vertices <= ranges::max_vertices && p.cut_budget.triangles <= ranges::max_triangles,
             "budgets keep to theirs");
        must(p.budget.vertices <= ranges::max_vertices && p.budget.indices <= ranges::max_indices,
             "budgets keep to theirs");
        must(p.width_px >= 1 && p.width_px <= ranges::max_size_px && p.height_px >= 1 &&
                 p.height_px <= ranges::max_size_px,
             "a size");
        must(p.fov_deg >= ranges::min_fov_deg && p.fov_deg <= ranges::max_fov_deg, "fov_deg keeps to its range");
        const Profile back = parse_profile(profile_text(p, profile_heading(text)), "fuzz: written");
        must(differing_keys(p, back).empty(), "what is written reads back");
        must(cut_settings(p, 1).max_error_px == p.refine.max_error_px, "both methods have the same error");
    } catch (const io::Failure& refused) {
        must(refused.exit_code == 1 && std::strncmp(refused.what(), "fuzz", 4) == 0, "a refusal names the file");
    }
    return 0;
}
