// Heights that stamps have changed (fjell/edit.h): the ground that a flight has dug, baked. And the paint over its
// maps.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "baker/read/source.h"
#include "io/stamps.h"

namespace fjell::baker {

// A pack that is flown with the stamps of a file has these heights, but for `smooth`, which goes on piece by piece
// there. Heights of a pack are rounded to its steps after each stamp, as they are in flight; those of other sources are
// not. What stamps change is held, 6 bytes a sample; most_edited_samples at most. What they cut out is void, and what
// they fill is not; other voids stay voids.
inline constexpr std::size_t most_edited_samples = std::size_t{1} << 27;

// path: stamps as JSON (content/README.md), whose frames give the order alone, or the pack's journal. Reads what they
// lie on. Throws Failure 1: a file that cannot be read, with its line, another pack's journal, stamps that change too
// much, or that fill a void under which nothing lies: only under a pack's holes, and those that stamps have cut, is
// ground.
[[nodiscard]] std::unique_ptr<HeightSource> edited_source(std::unique_ptr<HeightSource> source,
                                                          const std::string& path);
// The same, of stamps in memory. name: for messages.
[[nodiscard]] std::unique_ptr<HeightSource>
edited_source(std::unique_ptr<HeightSource> source, const std::vector<io::TimedStamp>& stamps, const std::string& name);

} // namespace fjell::baker
