// Any bytes as the set.json of a pack set: they are one, or are refused in a line; and what was read is, written, read
// again alike.
#include <cstdint>
#include <string>
#include <string_view>

#include "fjell/io/failure.h"
#include "input.h"
#include "io/set_file.h"

using namespace fjell;
using fuzz::must;

extern "C" int fuzz_set(const std::uint8_t* data, std::size_t size) {
    const std::string_view text{reinterpret_cast<const char*>(data), size};
    io::SetFile set;
    try {
        set = io::parse_set_file(text, "fuzz");
    } catch (const io::Failure& refused) {
        must(refused.exit_code == 1 && *refused.what(), "a refusal says why");
        must(std::string_view(refused.what()).find('\n') == std::string_view::npos, "a refusal is one line");
        return 0;
    }
    const std::string written = io::set_file_text(set);
    must(io::set_file_text(io::parse_set_file(written, "again")) == written, "what is written is what was read");
    return 0;
}
