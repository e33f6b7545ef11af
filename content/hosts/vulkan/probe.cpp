#include "probe.h"

#include <algorithm>

#include "probe_comp.h"

namespace vulkan {

namespace {

constexpr std::uint32_t bindings = 4; // of probe.comp: the frame, and three buffers

VkDescriptorType type_of(std::uint32_t binding) {
    return binding == 0 ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

} // namespace

Probe::Probe(Gpu& gpu, const Drawer& drawer) : gpu_(gpu) {
    const VkDeviceSize slots = drawer.vertices().bytes / sizeof(fjell::CompactVertex);
    const VkDeviceSize pixels = VkDeviceSize{drawer.size().width} * drawer.size().height;
    asked_ = gpu.make_buffer((1 + slots) * sizeof(Asked), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Where::host);
    answers_ = gpu.make_buffer(slots * sizeof(Answer), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Where::host);
    vertices_ = gpu.make_buffer(drawer.vertices().bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Where::host);
    indices_ = gpu.make_buffer(drawer.indices().bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Where::host);
    colours_ = gpu.make_buffer(4 * pixels, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Where::host);
    depths_ = gpu.make_buffer(4 * pixels, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Where::host);
    seen_.resize(slots);
    make_pipeline(drawer);
}

void Probe::make_pipeline(const Drawer& drawer) {
    VkDescriptorSetLayoutBinding bound[bindings]{};
    for (std::uint32_t i = 0; i < bindings; ++i)
        bound[i] = {.binding = i,
                    .descriptorType = type_of(i),
                    .descriptorCount = 1,
                    .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT,
                    .pImmutableSamplers = nullptr};
    const VkDevice device = gpu_.device();
    const VkDescriptorSetLayoutCreateInfo set{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = bindings, .pBindings = bound};
    must(vkCreateDescriptorSetLayout(device, &set, nullptr, &set_layout_), "making a layout");
    gpu_.at_end([device, made = set_layout_] { vkDestroyDescriptorSetLayout(device, made, nullptr); });
    const VkPipelineLayoutCreateInfo layout{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &set_layout_};
    must(vkCreatePipelineLayout(device, &layout, nullptr, &layout_), "making a layout");
    gpu_.at_end([device, made = layout_] { vkDestroyPipelineLayout(device, made, nullptr); });
    const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                           .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                     .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                     .module = gpu_.make_shader(probe_comp),
                                                     .pName = "main"},
                                           .layout = layout_};
    must(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_), "making a pipeline");
    gpu_.at_end([device, made = pipeline_] { vkDestroyPipeline(device, made, nullptr); });

    const VkDescriptorPoolSize sizes[] = {{type_of(0), 1}, {type_of(1), bindings - 1}};
    const VkDescriptorPoolCreateInfo pool_info{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 2, .pPoolSizes = sizes};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    must(vkCreateDescriptorPool(device, &pool_info, nullptr, &pool), "making descriptors");
    gpu_.at_end([device, pool] { vkDestroyDescriptorPool(device, pool, nullptr); });
    const VkDescriptorSetAllocateInfo one{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                          .descriptorPool = pool,
                                          .descriptorSetCount = 1,
                                          .pSetLayouts = &set_layout_};
    must(vkAllocateDescriptorSets(device, &one, &set_), "making descriptors");
    point_at(drawer);
}

// The drawer's block is another one in every frame; the device is done with the last probe by now.
void Probe::point_at(const Drawer& drawer) const {
    const VkDescriptorBufferInfo buffers[bindings] = {{drawer.frame_block().handle, 0, VK_WHOLE_SIZE},
                                                      {drawer.vertices().handle, 0, VK_WHOLE_SIZE},
                                                      {asked_.handle, 0, VK_WHOLE_SIZE},
                                                      {answers_.handle, 0, VK_WHOLE_SIZE}};
    for (std::uint32_t i = 0; i < bindings; ++i) {
        const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                         .dstSet = set_,
                                         .dstBinding = i,
                                         .descriptorCount = 1,
                                         .descriptorType = type_of(i),
                                         .pBufferInfo = &buffers[i]};
        vkUpdateDescriptorSets(gpu_.device(), 1, &write, 0, nullptr);
    }
}

void Probe::collect(const Drawer& drawer, const fjell::CutMesh& cut) {
    const std::span<Asked> asked = as<Asked>(asked_);
    std::fill(seen_.begin(), seen_.end(), std::uint8_t{0});
    count_ = 0;
    for (const fjell::TileRange& range : cut.mesh.tiles) {
        const std::uint32_t place = drawer.place_of(range.tile);
        for (const std::uint32_t slot : cut.mesh.indices.subspan(range.first_index, range.index_count))
            if (seen_[slot] == 0) {
                seen_[slot] = 1;
                asked[1 + count_++] = {slot, place};
            }
    }
    asked[0] = {count_, 0};
}

void Probe::record(VkCommandBuffer commands, const Drawer& drawer, const fjell::CutMesh& cut) {
    collect(drawer, cut);
    point_at(drawer);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
    vkCmdDispatch(commands, (count_ + 63) / 64, 1, 1);
    const VkBufferCopy all_vertices{0, 0, vertices_.bytes}, all_indices{0, 0, indices_.bytes};
    vkCmdCopyBuffer(commands, drawer.vertices().handle, vertices_.handle, 1, &all_vertices);
    vkCmdCopyBuffer(commands, drawer.indices().handle, indices_.handle, 1, &all_indices);
    const auto read = [&](const Image& image, VkImageAspectFlags aspect, const Buffer& to) {
        const VkBufferImageCopy all{.bufferOffset = 0,
                                    .bufferRowLength = 0,
                                    .bufferImageHeight = 0,
                                    .imageSubresource = {aspect, 0, 0, 1},
                                    .imageOffset = {0, 0, 0},
                                    .imageExtent = {drawer.size().width, drawer.size().height, 1}};
        vkCmdCopyImageToBuffer(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle, 1, &all);
    };
    read(drawer.colour(), VK_IMAGE_ASPECT_COLOR_BIT, colours_);
    read(drawer.depth(), VK_IMAGE_ASPECT_DEPTH_BIT, depths_);
    const VkMemoryBarrier2 to_host{
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
        .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
        .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    const VkDependencyInfo info{
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &to_host};
    vkCmdPipelineBarrier2(commands, &info);
}

} // namespace vulkan
