// The cut on the device: one copy of its buffers, edited in place, and two frames in flight.
//
// While the device draws a frame, the host stages the next one's changes in a buffer of that frame's own; the device
// copies them when the frames before have read their vertices. Memory is made once, for the budgets: a frame allocates
// nothing. Thread: the one that updates the cut. Failure: io::Failure with exit code 3.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <fjell/fjell.h>

#include "gpu.h"
#include "space.h"

namespace vulkan {

inline constexpr std::uint32_t frames_in_flight = 2;

// The uniform block of terrain.glsl.
struct FrameBlock {
    std::array<float, 16> clip_from_world;
    std::int32_t origin_sample[2];
    float spacing_m[2];
    float origin_height_m, now_s, morph_s;
    std::int32_t morph_views, tiles_x, tile_log2;
    float low_high_m[2];
    float morph_eye_m[fjell::max_cut_views][4], morph_q[fjell::max_cut_views][4];
};
static_assert(offsetof(FrameBlock, morph_eye_m) == 112 && sizeof(FrameBlock) == 368,
              "FrameBlock is uploaded: change terrain.glsl with it");

// to.size() slots of the cut as they are on the device.
void compact(const fjell::CutMesh& cut, std::uint32_t first, std::span<fjell::CompactVertex> to);
class Drawer {
public:
    Drawer(Gpu& gpu, const fjell::Terrain& terrain, const fjell::CutBudget& budget, VkExtent2D size);
    Drawer(const Drawer&) = delete;
    Drawer& operator=(const Drawer&) = delete;

    // A frame: these four, in this order, after the cut's update and before its next one. Between record() and submit()
    // others may record behind the picture.
    void wait(); // until the device is done with the frame before last
    std::uint64_t stage(const fjell::CutMesh& cut, const fjell::CutChanges& changes); // bytes that are copied
    VkCommandBuffer record(const fjell::CutMesh& cut, const fjell::View& view, const Origin& origin);
    void submit();
    void finish() const; // until the device is done with all

    // What shaders know a tile by: its place, row by row. Where tiles are missing, numbers leave those out.
    [[nodiscard]] std::uint32_t place_of(std::uint32_t tile) const;
    // Of the frame that is recorded: when it is drawn, both images are in TRANSFER_SRC_OPTIMAL.
    [[nodiscard]] const Image& colour() const { return frame().colour; }
    [[nodiscard]] const Image& depth() const { return frame().depth; }
    [[nodiscard]] const Buffer& frame_block() const { return frame().block; }
    [[nodiscard]] const Buffer& vertices() const { return vertices_; }
    [[nodiscard]] const Buffer& indices() const { return indices_; }
    [[nodiscard]] std::uint32_t index_bytes() const { return index_bytes_; }
    [[nodiscard]] VkExtent2D size() const { return size_; }
    [[nodiscard]] std::uint32_t draws() const { return draws_; }

private:
    struct Frame {
        VkCommandPool pool = VK_NULL_HANDLE;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        VkFence done = VK_NULL_HANDLE;
        VkDescriptorSet set = VK_NULL_HANDLE;
        Buffer block, staging, draws;
        Image colour, depth;
    };
    [[nodiscard]] const Frame& frame() const { return frames_[turn_]; }
    void make_frame(Frame& frame, VkDescriptorPool pool);
    void make_layouts();
    void make_pipeline();
    void write_block(const fjell::CutMesh& cut, const fjell::View& view, const Origin& origin) const;
    void write_draws(const fjell::CutMesh& cut);
    void copy_changes() const;
    void draw_ranges() const;

    Gpu& gpu_;
    fjell::Terrain terrain_;
    VkExtent2D size_;
    std::uint32_t index_bytes_; // 2 where 16 bits name every vertex slot
    Buffer vertices_, indices_;
    VkDescriptorSetLayout frame_layout_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    Frame frames_[frames_in_flight];
    std::vector<VkBufferCopy> vertex_runs_, index_runs_; // room for the most that there can be
    std::uint32_t turn_ = 0, draws_ = 0;
};

} // namespace vulkan
