// The keys of a profile as data: what each key is, its range, its cost, and what must be recreated when it changes. The
// reader and the writer of profiles and the controls of an editor use this one table.
//
// Ownership: the table is constant. Thread: any. Failure: only parse_value() can fail. Values that are passed to set()
// and to the writers must be in range.
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

// Ranges of values, for command lines and controls too.
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

// What must be recreated when a key changes.
enum class Rebuild : std::uint8_t {
    nothing, // the next update uses the new value
    // The method's memory (remake_method()), and a renderer with room for it.
    method,
    session // terrain, stream and method
};

// Which method or part a key affects.
enum class UsedBy : std::uint8_t { any, incremental, recursive, streaming };

struct ProfileKey {
    const char* table = nullptr;    // [table] in the file
    const char* name = nullptr;     // its name there
    const char* old_name = nullptr; // its name before 0.3, which is read until 0.4
    const char* label = nullptr;    // for a control: "Threshold"
    KeyKind kind = KeyKind::number;
    const char* unit = ""; // "px", "us", "vertices"; empty: none
    // Both are allowed. Flags: 0 to 1. Choices: 0 to their number less 1.
    double least = 0, most = 1;
    bool logarithmic = false;                  // for a slider; least may be 0 even then
    std::span<const char* const> choices = {}; // their names in the file
    // What 0 means if it is special: "no limit".
    const char* zero = nullptr;
    // One paragraph: what the key is, its unit and range, and what it costs.
    const char* about = nullptr;
    Rebuild rebuild = Rebuild::nothing;
    UsedBy used_by = UsedBy::any;
    double (*get)(const Profile&) = nullptr; // whole numbers and choices are exact in a double
    void (*set)(Profile&, double) = nullptr; // the value must be in range, and whole unless the kind is number
};
// All keys in the order of a profile, table by table. budget.vertices is one key for the budgets of both methods: get()
// reads that of the chosen method, set() sets both.
[[nodiscard]] std::span<const ProfileKey> profile_keys();
// Finds a key by its name, e.g. "refine.max_error_px", or by its old name. null if there is no such key.
[[nodiscard]] const ProfileKey* find_profile_key(std::string_view dotted);

struct ProfileTable {
    const char* name = nullptr;
    const char* label = nullptr; // for a control
    const char* about = nullptr; // null: its keys need no more
};
[[nodiscard]] std::span<const ProfileTable> profile_tables();

// A value as TOML writes it: 1.0, 4096, true, "none".
[[nodiscard]] std::string value_text(const ProfileKey& key, const Profile& profile);
// Reads a value as TOML writes it; choices need no quotes. Returns an empty string, or what is wrong: "must be a number
// from 0.01 to 1000 (pixels)". The value then stays as it was.
[[nodiscard]] std::string parse_value(const ProfileKey& key, std::string_view text, double& value);
// The message for any text that is not a value of the key.
[[nodiscard]] std::string key_refusal(const ProfileKey& key);
// What is wrong with keys that contradict each other, or empty. parse_profile() refuses such a profile.
[[nodiscard]] std::string profile_conflict(const Profile& profile);

// The whole profile as TOML, in lines of up to 120 characters. A comment above each key says what it is and costs.
// parse_profile() reads every key back to the last bit. heading: what the profile is for, one paragraph.
[[nodiscard]] std::string profile_text(const Profile& profile, std::string_view heading);
// The profile as C++ code: a line for each key that is not at its default.
[[nodiscard]] std::string profile_as_cpp(const Profile& profile);
// The first paragraph of a profile's text, for writing it again. Empty if it has none.
[[nodiscard]] std::string profile_heading(std::string_view text);
// The keys whose values differ between the two profiles.
[[nodiscard]] std::vector<const ProfileKey*> differing_keys(const Profile& a, const Profile& b);

} // namespace fjell
FJELL_API_END
