// Commands that study a terrain: runs that were flown, pictures rendered beside the frame, bookmarks, and two profiles
// in one picture. Part of editor/command.h, which every other file includes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>

namespace fjell::editor {

// --- runs that benchmarks flew (editor/runs.h) ---
struct ChoosePlace { // of a run, and look from there
    std::size_t run = 0;
    double share = 0; // 0..1 of its frames
};
struct ForgetRun {
    std::size_t run = 0;
};
enum class Heat : std::uint8_t { none, time, error };
inline constexpr const char* heat_names[] = {"none", "time", "error"};
struct SetHeat { // what the overview's path is coloured by, from the latest run
    Heat heat = Heat::none;
};

// --- pictures of any size, rendered beside the frame ---
struct RenderPicture { // of what the camera sees
    std::string path;  // .png
    std::uint32_t width = 3840, height = 2160;
};

// --- bookmarks ---
struct AddBookmark {
    std::string name; // empty: numbered
};
struct GoToBookmark {
    std::size_t bookmark = 0;
};
struct RemoveBookmark {
    std::size_t bookmark = 0;
};

// --- two profiles in one picture (editor/comparison.h) ---
enum class CompareWith : std::uint8_t { nothing, threshold, profile };
inline constexpr const char* compare_with_names[] = {"off", "threshold", "profile"};
struct ComparePictures {
    CompareWith with = CompareWith::nothing;
    double error_px = 0; // of a threshold; the rest is the profile's
};
enum class CompareView : std::uint8_t { split, difference };
inline constexpr const char* compare_view_names[] = {"split", "difference"};
struct SetCompareView {
    CompareView view = CompareView::split;
};
struct SetDivider {
    double share = 0.5; // of the picture's width: on its left the profile, on its right the other one
};

} // namespace fjell::editor
