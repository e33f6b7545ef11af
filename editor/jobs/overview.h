// The whole terrain from above, north up, in its own colours: painted from the pack's file, so that it is as fine at
// once as it will ever be, whatever is loaded of a streamed terrain.
//
// Colours are those of colour maps, under layers where these are on, as shaders lay them over near ground; a terrain
// with neither is coloured by height. Lit from the north-west, with slopes three times as steep, or a continent would
// be flat. Thread: any; it reads the file, so not the frame's. Memory: 16 bytes a texel, a terrain with the pages of
// one tile, and a tile's colours. O(texels), and reads of a tile what its texels take, of one without a texel nothing.
// Failure: what cannot be read is painted as coarse as what can; nothing is thrown but std::bad_alloc and io::Failure
// for a terrain that cannot be made.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "fjell/gl/layers.h"
#include "fjell/io/pack_file.h"
#include "session/layers_file.h"

namespace fjell::editor {

// What is painted.
struct OverviewSource {
    std::shared_ptr<const io::PackFile> pack;
    std::shared_ptr<const session::GroundLayers> layers; // null: none
    gl::LayerSettings settings;
};

struct OverviewSize {
    static constexpr std::uint32_t longer_texels = 256, least_texels = 16;
    std::uint32_t columns = 0, rows = 0;

    [[nodiscard]] std::size_t texels() const { return std::size_t{columns} * rows; }
};
[[nodiscard]] OverviewSize overview_size_of(const PackHeader& header);
inline constexpr std::uint32_t overview_ground = 0xff2a2520u; // no texel yet, and holes: the panels' grey

// Called now and then with the share that is painted and all texels, RGBA bytes, sRGB: grey where none is painted yet,
// and in holes; the last time with share 1. False: stop.
using OverviewShow = std::function<bool(double share, std::span<const std::uint32_t> texels)>;
// stopped: asked after every page and every row of texels. False: it was stopped.
bool paint_overview(const OverviewSource& source, const std::function<bool()>& stopped, const OverviewShow& show);

// --- The overview, painted by a thread of its own while frames go on.
//
// The thread shares a sheet of texels with the frame, behind a lock that the frame takes only when there is something
// new, and leaves alone while the thread has it. One that is no longer wanted is told to stop, and joined when it has:
// no frame waits for the page that it reads. Ownership: the threads. Thread: the frame's. Memory: 4 bytes a texel, and
// what painting takes while it goes on; take() allocates nothing. Failure: what cannot be painted stays grey.

class OverviewJob {
public:
    OverviewJob() = default;
    ~OverviewJob(); // waits for its threads, which stop after the page that they read
    OverviewJob(const OverviewJob&) = delete;
    OverviewJob& operator=(const OverviewJob&) = delete;

    // Another terrain, from nothing, or the same in other colours.
    void begin(OverviewSource source);
    void end(); // no terrain
    [[nodiscard]] bool there() const { return now_.sheet != nullptr; }
    // Something was painted since take().
    [[nodiscard]] bool news() const;
    // All that there will be is painted and taken.
    [[nodiscard]] bool done() const;
    // Gives what is painted so far: all texels, and the share of them that are no longer grey. False: the thread is
    // writing them, or there is none.
    using Take = void (*)(void* to, OverviewSize size, double share, std::span<const std::uint32_t> texels);
    bool take(Take give, void* to);

private:
    struct Sheet;
    struct Painting {
        std::shared_ptr<Sheet> sheet;
        std::jthread thread;
    };
    static void paint(Sheet& sheet, const OverviewSource& source, const std::stop_token& stop);
    void leave();

    Painting now_; // sheet null: none
    std::vector<Painting> leaving_;
};

} // namespace fjell::editor
