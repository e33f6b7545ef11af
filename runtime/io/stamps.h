// Stamps of moving ground (fjell/edit.h) as JSON: those of a flight (fjell-fly --edits, content/edits), and those of a
// recording. content/README.md has the fields.
//
// Failure: io::Failure with exit code 1. parse_stamps() names the file, the line, the stamp and the field. What it
// takes push_stamp() takes too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "fjell/edit.h"

namespace fjell::io {

// A stamp with what it points to.
struct KeptStamp {
    Stamp plain; // without its pointers
    std::vector<StampPoint> points;
    std::vector<float> heights_m;
    std::vector<std::uint8_t> mask;
    // Points into this object.
    [[nodiscard]] Stamp stamp() const;
};

struct TimedStamp {
    std::size_t frame = 0; // in which it is pushed
    KeptStamp what;
};

// By frame; those of one frame in the order of the text.
[[nodiscard]] std::vector<TimedStamp> parse_stamps(std::string_view text, const std::string& name);
// As parse_stamps() reads it.
[[nodiscard]] std::string write_stamps(const std::vector<TimedStamp>& stamps);

// One stamp, without its frame. The message says what is wrong, and not where.
[[nodiscard]] KeptStamp stamp_of(const nlohmann::json& object);
[[nodiscard]] nlohmann::json stamp_json(const KeptStamp& stamp);

} // namespace fjell::io
