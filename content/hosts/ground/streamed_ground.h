// Ground without a picture: a terrain that is streamed around places instead of cameras. Of the physics and the server.
// It is not io::LiveTerrain: that owns a cut, whose memory and work are wasted where nothing is drawn, and it reads
// when its threads please, where a simulation must repeat itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <fjell/fjell.h>

#include "../game/loader.h"

namespace ground {

// A view that nobody looks through: ground whose pages hide more than accuracy_m is wanted within reach_m of a place,
// rougher ground farther away in proportion. The page slots limit how much; what is nearest comes first.
[[nodiscard]] fjell::View focus(fjell::Vec3 place_m, double reach_m, double accuracy_m);

class StreamedGround {
public:
    StreamedGround() = default;
    ~StreamedGround(); // whoever answers requests has ended
    StreamedGround(const StreamedGround&) = delete;
    StreamedGround& operator=(const StreamedGround&) = delete;

    // The file must stay. Empty, or one sentence that says what is wrong. Afterwards nothing is allocated.
    [[nodiscard]] std::string create(const game::PackOnDisk& file, std::uint32_t page_slots);
    // One tick: applies stamps, inserts pages that have come, asks for others. 1 to fjell::max_cut_views views.
    [[nodiscard]] fjell::Status update(std::span<const fjell::View> views, double now_s);
    // What the last tick's stamps have changed; the whole terrain if that is too much to remember.
    [[nodiscard]] std::span<const fjell::GroundRect> changes() const { return changes_; }
    // Answers up to so many requests on this thread, for a program that has to repeat itself; see also game::Loader.
    void answer(int most);

    [[nodiscard]] const fjell::Terrain& terrain() const { return terrain_; }
    [[nodiscard]] fjell::Stream stream() const { return stream_; }
    [[nodiscard]] fjell::Edits edits() const { return edits_; } // for stamps, on any thread
    [[nodiscard]] const fjell::StreamReport& report() const { return report_; }
    [[nodiscard]] std::size_t bytes() const { return bytes_; } // that were handed to Fjell
    [[nodiscard]] std::uint64_t came() const { return came_; } // pages, so far
    [[nodiscard]] std::uint64_t went() const { return went_; }

private:
    game::Memory memory_;
    const game::PackOnDisk* file_ = nullptr;
    fjell::Terrain terrain_;
    fjell::Edits edits_;
    fjell::Stream stream_;
    fjell::StreamReport report_;
    std::vector<fjell::GroundRect> changes_;
    std::uint64_t seen_ = 0; // of the changes
    std::vector<std::byte> read_;
    std::size_t bytes_ = 0;
    std::uint64_t came_ = 0, went_ = 0;
};

// All of a pack in memory: the full-resolution surface that a check compares with. A game has no use for it.
class Yardstick {
public:
    [[nodiscard]] std::string create(const game::PackOnDisk& file);
    [[nodiscard]] const fjell::Terrain& terrain() const { return terrain_; }
    // The same change of the ground, at once. Empty, or one sentence.
    [[nodiscard]] std::string stamp(const fjell::Stamp& stamp);

private:
    game::Memory memory_;
    fjell::Terrain terrain_;
    fjell::Edits edits_;
};

// "field: what is wrong and what to do about it", or empty.
[[nodiscard]] std::string text_of(fjell::Status status);

} // namespace ground
