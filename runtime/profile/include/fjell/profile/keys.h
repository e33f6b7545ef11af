// A profile's keys as data: what each is, what it may be, what it costs, and what has to be recreated when it changes.
// The reader of profiles, what writes them and an editor's controls all go by this one table.
//
// Ownership: none, the table is constant. Thread: any. Failure: none but parse_value()'s answer; values that set() and
// the writers are given must be in range.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/export.h"
#include "fjell/profile.h"

FJELL_API_BEGIN
namespace fjell {

// Of values, for command lines and controls too.
namespace ranges {
inline constexpr double least_threshold_px = 0.01, most_threshold_px = 1000;
inline constexpr double min_fov_deg = 1, max_fov_deg = 150;
inline constexpr std::uint32_t max_size_px = 16384, max_samples = 16;
inline constexpr std::uint32_t min_budget = 16, max_vertices = 1u << 27, max_indices = 1u << 30;
inline constexpr std::uint32_t max_triangles = 1u << 29, most_work = unlimited_work - 1;
inline constexpr std::uint32_t max_page_slots = 1u << 24, max_page_requests = 256, max_map_requests = 64;
inline constexpr std::uint32_t max_map_mb = 1u << 16, max_material_mb = 1u << 16, max_map_kb = 1u << 20,
                               min_tail_log2 = 2, most_decoders = 16;
inline constexpr std::uint32_t max_stream_pages = 4096, min_stream_tests = 1024;
inline constexpr double min_texel_px = 0.1, max_texel_px = 100, max_lookahead_s = 10, max_fade_s = 10;
inline constexpr double max_hysteresis = 10, min_morph_s = 0.01, max_morph_s = 10, most_time_us = 1e6;
} // namespace ranges

enum class KeyKind : std::uint8_t { number, whole, flag, choice };

// What a change takes before the next update.
enum class Rebuild : std::uint8_t {
    nothing, // the next update goes by it
    method,  // the method's memory (remake_method()) and a renderer with room for it
    session  // terrain, stream and method
};

// Where a key counts.
enum class UsedBy : std::uint8_t { any, incremental, recursive, streaming };

struct ProfileKey {
    const char* table = nullptr;    // [table] in the file
    const char* name = nullptr;     // and in it
    const char* old_name = nullptr; // before 0.3; read until 0.4
    const char* label = nullptr;    // for a control: "Threshold"
    KeyKind kind = KeyKind::number;
    const char* unit = "";                     // "px", "us", "vertices"; empty: none
    double least = 0, most = 1;                // both allowed; flags 0 to 1, choices 0 to their number less 1
    bool logarithmic = false;                  // how a slider runs; least may be 0 all the same
    std::span<const char* const> choices = {}; // their names in the file
    const char* zero = nullptr;                // what 0 means, where it is more than a little: "no limit"
    const char* about = nullptr;               // what it is, its unit and range, what it costs: one paragraph
    Rebuild rebuild = Rebuild::nothing;
    UsedBy used_by = UsedBy::any;
    double (*get)(const Profile&) = nullptr; // whole numbers and choices are exact in a double
    void (*set)(Profile&, double) = nullptr; // in range, and whole but for numbers
};
// In the order in which a profile has them, table by table. budget.vertices is one key for both methods' budgets: it is
// got from the chosen method's and set in both.
[[nodiscard]] std::span<const ProfileKey> profile_keys();
// "refine.max_error_px", or the name that it had; null: there is none.
[[nodiscard]] const ProfileKey* find_profile_key(std::string_view dotted);

struct ProfileTable {
    const char* name = nullptr;
    const char* label = nullptr; // for a control
    const char* about = nullptr; // null: its keys say it all
};
[[nodiscard]] std::span<const ProfileTable> profile_tables();

// As TOML writes it: 1.0, 4096, true, "none".
[[nodiscard]] std::string value_text(const ProfileKey& key, const Profile& profile);
// The other way, and choices without their quotes too. Empty, or what is wrong: "must be a number from 0.01 to 1000
// (pixels)", and then the value is as it was.
[[nodiscard]] std::string parse_value(const ProfileKey& key, std::string_view text, double& value);
// What any text that is no value of the key is refused with.
[[nodiscard]] std::string key_refusal(const ProfileKey& key);
// Of keys that do not go together: what is wrong, or empty. parse_profile() refuses what this does.
[[nodiscard]] std::string profile_conflict(const Profile& profile);

// The whole profile as TOML, every key under what it is and costs, in lines of up to 120 characters. parse_profile()
// reads every key back to the last bit. heading: what the profile is for, one paragraph.
[[nodiscard]] std::string profile_text(const Profile& profile, std::string_view heading);
// The profile as C++ that makes it: a line for each key that is not at its default.
[[nodiscard]] std::string profile_as_cpp(const Profile& profile);
// The paragraph that a profile's text begins with, for writing it again; empty where there is none.
[[nodiscard]] std::string profile_heading(std::string_view text);
// Keys of which the two have different values.
[[nodiscard]] std::vector<const ProfileKey*> differing_keys(const Profile& a, const Profile& b);

} // namespace fjell
FJELL_API_END
