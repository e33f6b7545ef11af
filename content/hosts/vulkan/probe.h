// What a check reads back from the device: the picture, its depths, both buffers, and where the drawing code's morphing
// puts the vertices. A game has no use for it.
//
// Memory: made once. Thread: the drawer's. Failure: io::Failure with exit code 3.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <fjell/fjell.h>

#include "drawer.h"
#include "gpu.h"

namespace vulkan {

class Probe {
public:
    Probe(Gpu& gpu, const Drawer& drawer);
    Probe(const Probe&) = delete;
    Probe& operator=(const Probe&) = delete;

    // A vertex slot, and the place of a tile of the triangles that use it.
    struct Asked {
        std::uint32_t slot, place;
    };
    struct Answer { // where it is drawn: host's axes, counted from the origin
        float x_m, y_m, z_m, one;
    };
    // Of the slots that the cut's ranges use, each once. Records behind the picture; read the rest when it is drawn.
    void record(VkCommandBuffer commands, const Drawer& drawer, const fjell::CutMesh& cut);

    [[nodiscard]] std::span<const Asked> asked() const { return as<const Asked>(asked_).subspan(1, count_); }
    [[nodiscard]] std::span<const Answer> answers() const { return as<const Answer>(answers_).first(count_); }
    [[nodiscard]] std::span<const fjell::CompactVertex> vertices() const {
        return as<const fjell::CompactVertex>(vertices_);
    }
    [[nodiscard]] std::span<const std::byte> indices() const { return {indices_.mapped, indices_.bytes}; }
    [[nodiscard]] std::span<const std::uint32_t> colours() const { return as<const std::uint32_t>(colours_); }
    [[nodiscard]] std::span<const float> depths() const { return as<const float>(depths_); } // row by row from the top

private:
    template <typename T>
    [[nodiscard]] static std::span<T> as(const Buffer& buffer) {
        return {reinterpret_cast<T*>(buffer.mapped), buffer.bytes / sizeof(T)};
    }
    void make_pipeline(const Drawer& drawer);
    void collect(const Drawer& drawer, const fjell::CutMesh& cut);
    void point_at(const Drawer& drawer) const;

    Gpu& gpu_;
    Buffer asked_, answers_, vertices_, indices_, colours_, depths_;
    VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    std::vector<std::uint8_t> seen_; // a slot
    std::uint32_t count_ = 0;
};

} // namespace vulkan
