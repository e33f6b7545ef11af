// The methods that refine a session's terrain, behind one interface. A session makes one (session.cpp) and a profile
// names one; beyond this folder nobody asks which it is, but for what it can do.
//
// incremental.cpp: fjell/cut.h. recursive.cpp: fjell/recursive.h, the thesis' own, as lists or strips, over packs in
// any order of vertices. Ownership: a running method owns its memory; the terrain must outlive it. Thread: one.
// Failure: io::Failure, 1 for unusable budgets or an unusable pack, 3 when memory is short.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "fjell/cut.h"
#include "fjell/io/load.h"
#include "fjell/profile.h"
#include "fjell/profile/keys.h"
#include "session/log.h"
#include "session/options.h"
#include "session/record.h"

namespace fjell::gl {
struct RendererOptions;
class Renderer;
} // namespace fjell::gl
namespace fjell::gltf {
class Snapshot;
struct SnapshotResult;
} // namespace fjell::gltf

namespace fjell::session {

// What a method can do and what its slots cost, known before there is one.
struct MethodFacts {
    const char* name; // in a profile and on the command line
    UsedBy keys;      // which only it reads
    // The mesh is kept from frame to frame: items and time bound the work, triangles have slots, frames are recorded.
    bool keeps_mesh;
    std::size_t vertex_bytes, gpu_vertex_bytes;        // for a slot of the vertex buffer; of cut_page_bytes apart
    std::size_t gpu_triangle_bytes;                    // for a triangle slot, or an index
    std::uint32_t (*vertices)(const Profile& profile); // slots of its budget
    // The budget holds the coarsest mesh of so many tiles.
    bool (*holds)(const Profile& profile, std::uint64_t tiles_x, std::uint64_t tiles_y);
};
[[nodiscard]] const MethodFacts& facts_of(Method method);
[[nodiscard]] inline const MethodFacts& facts_of(const Profile& profile) {
    return facts_of(profile.method);
}

// For the message that refuses a budget: with which larger tiles the profile holds the pack's coarsest mesh. Empty:
// with none.
[[nodiscard]] std::string fewer_tiles(const PackHeader& header, const Profile& profile);

// Throws what a status says: 1, and for a budget with what would fit.
void require(const Status& status);
void require_budget(const Status& status, const FlightOptions& options, const PackHeader& header);

class RunningMethod {
public:
    RunningMethod(Method method, const Terrain& terrain, std::size_t bytes)
        : kind(method), terrain_(terrain), bytes_(bytes), memory_(io::allocate(bytes)) {}
    virtual ~RunningMethod() = default;
    RunningMethod(const RunningMethod&) = delete;
    RunningMethod& operator=(const RunningMethod&) = delete;

    const Method kind;
    [[nodiscard]] std::size_t bytes() const { return bytes_; }
    [[nodiscard]] const std::optional<View>& view() const { return view_; } // of the last update, if there was one

    // One update, timed. anew: the mesh is built from nothing. now_s: for morphing.
    virtual FrameEntry update(std::span<const View> views, const Profile& profile, double now_s, bool anew) = 0;
    // The update that was recorded. Only of a method that keeps its mesh, as are what it records and the cut.
    virtual FrameEntry replay(const RecordedFrame& frame);
    [[nodiscard]] virtual RecordedFrame recorded() const { return {}; } // the last update
    [[nodiscard]] virtual CutBudget cut_budget() const { return {}; }
    [[nodiscard]] virtual LiveCut cut() const { return {}; }

    // Of the last update: the mesh, and how it morphs if it does.
    [[nodiscard]] virtual CutMesh mesh() const = 0;
    // Only what lies in the frustum is refined, or listed.
    [[nodiscard]] virtual bool within_frustum(const Profile& profile) const = 0;

    // The slots of a renderer that has room for the mesh; and the last update's part of it, for one that has.
    virtual void make_room(const Profile& profile, bool streamed, gl::RendererOptions& slots) const = 0;
    virtual void upload(gl::Renderer& renderer) const = 0;

    // The mesh of the last update as it stands, and the one that its view would settle on.
    [[nodiscard]] virtual gltf::Snapshot take_frame() const = 0;
    [[nodiscard]] virtual gltf::Snapshot take_converged() const = 0;

    // What it was told, for the JSON of a flight.
    [[nodiscard]] virtual nlohmann::json described(const Profile& profile) const = 0;

protected:
    [[nodiscard]] std::span<std::byte> memory() const { return {memory_.get(), bytes_}; }
    const Terrain& terrain_;
    std::optional<View> view_;

private:
    std::size_t bytes_;
    io::AlignedMemory memory_;
};

// recorded: the budget of what is replayed, instead of the profile's.
[[nodiscard]] std::unique_ptr<RunningMethod> make_incremental(const FlightOptions& options, const Terrain& terrain,
                                                              const CutBudget* recorded);
[[nodiscard]] std::unique_ptr<RunningMethod> make_recursive(const FlightOptions& options, const Terrain& terrain);

} // namespace fjell::session
