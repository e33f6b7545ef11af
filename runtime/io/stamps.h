// Stamps of moving ground (fjell/edit.h) as JSON: those of a flight (fjell-fly --edits, content/edits), and those of a
// recording. content/README.md has the fields.
//
// Failure: io::Failure with exit code 1. parse_stamps() names the file, the line, the stamp and the field. What it
// takes push_stamp() takes too.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "fjell/edit.h"
#include "fjell/io/journal.h"

namespace fjell::io {

struct TimedStamp {
    std::size_t frame = 0; // in which it is pushed
    KeptStamp what;
};

// By frame; those of one frame in the order of the text.
[[nodiscard]] std::vector<TimedStamp> parse_stamps(std::string_view text, const std::string& name);
// Of a file of stamps, or of a journal (fjell/io/journal.h), whose stamps all come in frame 0. pack: the header of the
// pack that a journal must belong to; null: of any.
[[nodiscard]] std::vector<TimedStamp> read_stamps(const std::string& path, const PackHeader* pack = nullptr);
// As parse_stamps() reads it.
[[nodiscard]] std::string write_stamps(const std::vector<TimedStamp>& stamps);

// A colour in six hexadecimal digits. Failure (2) with the option's name.
[[nodiscard]] std::array<std::uint8_t, 3> rgb_of(const std::string& text, const char* option);

// One stamp, without its frame. The message says what is wrong, and not where.
[[nodiscard]] KeptStamp stamp_of(const nlohmann::json& object);
[[nodiscard]] nlohmann::json stamp_json(const KeptStamp& stamp);

} // namespace fjell::io
