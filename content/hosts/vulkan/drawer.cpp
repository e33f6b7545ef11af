#include "drawer.h"

#include <cstring>

#include "terrain_frag.h"
#include "terrain_vert.h"

namespace vulkan {

namespace {

constexpr VkFormat colour_format = VK_FORMAT_R8G8B8A8_SRGB, depth_format = VK_FORMAT_D32_SFLOAT;

// What came before is done, and seen by what comes after.
void barrier(VkCommandBuffer commands, VkPipelineStageFlags2 before, VkAccessFlags2 wrote, VkPipelineStageFlags2 after,
             VkAccessFlags2 reads) {
    const VkMemoryBarrier2 all{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                               .srcStageMask = before,
                               .srcAccessMask = wrote,
                               .dstStageMask = after,
                               .dstAccessMask = reads};
    const VkDependencyInfo info{
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &all};
    vkCmdPipelineBarrier2(commands, &info);
}

void change_layout(VkCommandBuffer commands, const Image& image, VkImageAspectFlags aspect, VkImageLayout from,
                   VkImageLayout to, VkPipelineStageFlags2 before, VkAccessFlags2 wrote, VkPipelineStageFlags2 after,
                   VkAccessFlags2 uses) {
    const VkImageMemoryBarrier2 one{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                    .srcStageMask = before,
                                    .srcAccessMask = wrote,
                                    .dstStageMask = after,
                                    .dstAccessMask = uses,
                                    .oldLayout = from,
                                    .newLayout = to,
                                    .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                    .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                    .image = image.handle,
                                    .subresourceRange = {aspect, 0, 1, 0, 1}};
    const VkDependencyInfo info{
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &one};
    vkCmdPipelineBarrier2(commands, &info);
}

constexpr VkPipelineStageFlags2 reads_vertices = VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT |
                                                 VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT |
                                                 VK_PIPELINE_STAGE_2_COPY_BIT; // a check does
constexpr VkPipelineStageFlags2 depth_tests =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;

// A run more, or a longer one where it continues the last.
void add_run(std::vector<VkBufferCopy>& runs, VkBufferCopy run) {
    if (!runs.empty() && runs.back().srcOffset + runs.back().size == run.srcOffset &&
        runs.back().dstOffset + runs.back().size == run.dstOffset)
        runs.back().size += run.size;
    else
        runs.push_back(run); // reserved
}

} // namespace

Drawer::Drawer(Gpu& gpu, const fjell::Terrain& terrain, const fjell::CutBudget& budget, VkExtent2D size)
    : gpu_(gpu), terrain_(terrain), size_(size), index_bytes_(fjell::index_bytes(budget)) {
    // Read by whoever checks, too: a game leaves out TRANSFER_SRC and STORAGE.
    vertices_ = gpu.make_buffer(budget.vertices * sizeof(fjell::CompactVertex),
                                VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                    VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                Where::device);
    indices_ = gpu.make_buffer(VkDeviceSize{budget.triangles} * 3 * index_bytes_,
                               VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                   VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                               Where::device);
#ifndef PLANT_NO_ROOM
    vertex_runs_.reserve(budget.vertices / 2 + 1);
    index_runs_.reserve(budget.triangles / 2 + 1);
#endif
    make_layouts();
    make_pipeline();
    const VkDescriptorPoolSize blocks{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, frames_in_flight};
    const VkDescriptorPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                          .maxSets = frames_in_flight,
                                          .poolSizeCount = 1,
                                          .pPoolSizes = &blocks};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    must(vkCreateDescriptorPool(gpu.device(), &info, nullptr, &pool), "making descriptors");
    gpu.at_end([device = gpu.device(), pool] { vkDestroyDescriptorPool(device, pool, nullptr); });
    for (Frame& frame : frames_) {
        // All slots may change at once, as they do after a teleport.
        frame.staging =
            gpu.make_buffer(vertices_.bytes + indices_.bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Where::host);
        // A tile's last segment may be started only, so there are no more ranges than segments.
        const VkDeviceSize ranges = budget.triangles / budget.segment_triangles + 1;
        frame.draws = gpu.make_buffer(ranges * sizeof(VkDrawIndexedIndirectCommand),
                                      VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, Where::host);
        make_frame(frame, pool);
    }
}

void Drawer::make_frame(Frame& frame, VkDescriptorPool pool) {
    frame.block = gpu_.make_buffer(sizeof(FrameBlock), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, Where::host);
    frame.colour = gpu_.make_image(colour_format, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                                   VK_IMAGE_ASPECT_COLOR_BIT, size_);
    frame.depth =
        gpu_.make_image(depth_format, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                        VK_IMAGE_ASPECT_DEPTH_BIT, size_);
    const VkCommandPoolCreateInfo commands{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                           .queueFamilyIndex = gpu_.queue_family()};
    must(vkCreateCommandPool(gpu_.device(), &commands, nullptr, &frame.pool), "making commands");
    gpu_.at_end([device = gpu_.device(), made = frame.pool] { vkDestroyCommandPool(device, made, nullptr); });
    const VkCommandBufferAllocateInfo one{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                          .commandPool = frame.pool,
                                          .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                          .commandBufferCount = 1};
    must(vkAllocateCommandBuffers(gpu_.device(), &one, &frame.commands), "making commands");
    const VkFenceCreateInfo fence{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, .flags = VK_FENCE_CREATE_SIGNALED_BIT};
    must(vkCreateFence(gpu_.device(), &fence, nullptr, &frame.done), "making a fence");
    gpu_.at_end([device = gpu_.device(), made = frame.done] { vkDestroyFence(device, made, nullptr); });

    const VkDescriptorSetAllocateInfo set{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                          .descriptorPool = pool,
                                          .descriptorSetCount = 1,
                                          .pSetLayouts = &frame_layout_};
    must(vkAllocateDescriptorSets(gpu_.device(), &set, &frame.set), "making descriptors");
    const VkDescriptorBufferInfo whole{frame.block.handle, 0, VK_WHOLE_SIZE};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = frame.set,
                                     .descriptorCount = 1,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                     .pBufferInfo = &whole};
    vkUpdateDescriptorSets(gpu_.device(), 1, &write, 0, nullptr);
}

void Drawer::make_layouts() {
    const VkDescriptorSetLayoutBinding block{.binding = 0,
                                             .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                             .descriptorCount = 1,
                                             .stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT};
    const VkDescriptorSetLayoutCreateInfo set{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &block};
    must(vkCreateDescriptorSetLayout(gpu_.device(), &set, nullptr, &frame_layout_), "making a layout");
    gpu_.at_end(
        [device = gpu_.device(), made = frame_layout_] { vkDestroyDescriptorSetLayout(device, made, nullptr); });
    const VkPipelineLayoutCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &frame_layout_};
    must(vkCreatePipelineLayout(gpu_.device(), &info, nullptr, &layout_), "making a layout");
    gpu_.at_end([device = gpu_.device(), made = layout_] { vkDestroyPipelineLayout(device, made, nullptr); });
}

void Drawer::make_pipeline() {
    const auto stage = [&](VkShaderStageFlagBits which, std::span<const std::uint32_t> code) {
        return VkPipelineShaderStageCreateInfo{.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                               .stage = which,
                                               .module = gpu_.make_shader(code),
                                               .pName = "main"};
    };
    const VkPipelineShaderStageCreateInfo stages[] = {stage(VK_SHADER_STAGE_VERTEX_BIT, terrain_vert),
                                                      stage(VK_SHADER_STAGE_FRAGMENT_BIT, terrain_frag)};
    const VkVertexInputBindingDescription record{0, sizeof(fjell::CompactVertex), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription words{0, 0, VK_FORMAT_R32G32B32A32_UINT, 0}; // the shader takes it apart
    const VkPipelineVertexInputStateCreateInfo input{.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                     .vertexBindingDescriptionCount = 1,
                                                     .pVertexBindingDescriptions = &record,
                                                     .vertexAttributeDescriptionCount = 1,
                                                     .pVertexAttributeDescriptions = &words};
    const VkPipelineInputAssemblyStateCreateInfo lists{.sType =
                                                           VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                       .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    // Upside down, so that clip space's y points up as in the host's world.
    const VkViewport viewport{0, float(size_.height), float(size_.width), -float(size_.height), 0, 1};
    const VkRect2D all{{0, 0}, size_};
    const VkPipelineViewportStateCreateInfo where{.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                                  .viewportCount = 1,
                                                  .pViewports = &viewport,
                                                  .scissorCount = 1,
                                                  .pScissors = &all};
    const VkPipelineRasterizationStateCreateInfo raster{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1};
    const VkPipelineMultisampleStateCreateInfo samples{.sType =
                                                           VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                       .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    const VkPipelineDepthStencilStateCreateInfo reversed{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = VK_TRUE,
        .depthWriteEnable = VK_TRUE,
        .depthCompareOp = VK_COMPARE_OP_GREATER}; // 1 at the near plane, 0 infinitely far
    VkPipelineColorBlendAttachmentState opaque{};
    opaque.colorWriteMask = 0xf; // all of red, green, blue, alpha
    const VkPipelineColorBlendStateCreateInfo blend{.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                    .attachmentCount = 1,
                                                    .pAttachments = &opaque};
    const VkPipelineRenderingCreateInfo formats{.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                .colorAttachmentCount = 1,
                                                .pColorAttachmentFormats = &colour_format,
                                                .depthAttachmentFormat = depth_format};
    const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                            .pNext = &formats,
                                            .stageCount = 2,
                                            .pStages = stages,
                                            .pVertexInputState = &input,
                                            .pInputAssemblyState = &lists,
                                            .pViewportState = &where,
                                            .pRasterizationState = &raster,
                                            .pMultisampleState = &samples,
                                            .pDepthStencilState = &reversed,
                                            .pColorBlendState = &blend,
                                            .layout = layout_};
    must(vkCreateGraphicsPipelines(gpu_.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_), "making a pipeline");
    gpu_.at_end([device = gpu_.device(), made = pipeline_] { vkDestroyPipeline(device, made, nullptr); });
}

void Drawer::wait() {
    turn_ = (turn_ + 1) % frames_in_flight;
    must(vkWaitForFences(gpu_.device(), 1, &frame().done, VK_TRUE, UINT64_MAX), "waiting for the device");
    must(vkResetFences(gpu_.device(), 1, &frame().done), "waiting for the device");
    must(vkResetCommandPool(gpu_.device(), frame().pool, 0), "recording");
}

void compact(const fjell::CutMesh& cut, std::uint32_t first, std::span<fjell::CompactVertex> to) {
    fjell::compact_vertices(cut.mesh.vertices.subspan(first, to.size()), cut.morph.subspan(first, to.size()), to);
#ifdef PLANT_ROUNDED_DOWN // a test's mistake
    for (fjell::CompactVertex& vertex : to) {
        vertex.error -= vertex.error > 0;
        vertex.radius -= vertex.radius > 0;
    }
#endif
}

std::uint64_t Drawer::stage(const fjell::CutMesh& cut, const fjell::CutChanges& changes) {
    vertex_runs_.clear();
    index_runs_.clear();
    VkDeviceSize used = 0; // of the frame's staging buffer
    fjell::for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t first, std::uint32_t count) {
        constexpr VkDeviceSize record = sizeof(fjell::CompactVertex);
        compact(cut, first, {reinterpret_cast<fjell::CompactVertex*>(frame().staging.mapped + used), count});
        add_run(vertex_runs_, {used, first * record, count * record});
        used += count * record;
    });
    fjell::for_each_run(changes.triangle_bits, changes.triangle_words, [&](std::uint32_t first, std::uint32_t count) {
        const VkDeviceSize record = VkDeviceSize{3} * index_bytes_;
        const std::span<const std::uint32_t> from =
            cut.mesh.indices.subspan(std::size_t{3} * first, std::size_t{3} * count);
        std::byte* const to = frame().staging.mapped + used;
        if (index_bytes_ == 4)
            std::memcpy(to, from.data(), from.size_bytes());
        else
            fjell::compact_indices(from, {reinterpret_cast<std::uint16_t*>(to), from.size()});
        add_run(index_runs_, {used, first * record, count * record});
        used += count * record;
    });
#ifdef PLANT_FORGOTTEN_RUN
    if (vertex_runs_.size() > 1) vertex_runs_.pop_back();
#endif
    return used;
}

void Drawer::write_block(const fjell::CutMesh& cut, const fjell::View& view, const Origin& origin) const {
    const fjell::PackHeader& header = terrain_.header();
    const fjell::MorphFrame& morph = cut.frame;
    FrameBlock block{.clip_from_world = clip_from_world(view, origin),
                     .origin_sample = {origin.column(), origin.row()},
                     .spacing_m = {terrain_.spacing_x_m(), terrain_.spacing_z_m()},
                     .origin_height_m = float(origin.position_m().z),
                     .now_s = morph.now_s,
                     .morph_s = morph.morph_s,
                     .morph_views = morph.morph == fjell::Morph::none ? 0 : std::int32_t(morph.views),
                     .tiles_x = std::int32_t(header.tiles_x),
                     .tile_log2 = std::int32_t(header.tile_log2),
                     .low_high_m = {header.min_m, header.max_m},
                     .morph_eye_m = {},
                     .morph_q = {}};
    for (std::uint32_t i = 0; i < morph.views; ++i) { // every view that refines counts, whichever is drawn
        const fjell::MorphView& m = morph.view[i];
        const auto eye = origin.relative(from_scene({double(m.eye_x), double(m.eye_y), double(m.eye_z)}));
        std::copy(eye.begin(), eye.end(), block.morph_eye_m[i]);
        block.morph_q[i][0] = m.start_per_error;
        block.morph_q[i][1] = m.full_per_error;
    }
    std::memcpy(frame().block.mapped, &block, sizeof block);
}

std::uint32_t Drawer::place_of(std::uint32_t tile) const {
    const fjell::SampleIndex place = terrain_.tile_place(tile);
    return std::uint32_t(place.row) * terrain_.header().tiles_x + std::uint32_t(place.column);
}

// A range of a tile is a draw, and firstInstance says where the tile lies. Those that no view sees are not among them.
void Drawer::write_draws(const fjell::CutMesh& cut) {
    auto* const draws = reinterpret_cast<VkDrawIndexedIndirectCommand*>(frame().draws.mapped);
    draws_ = 0;
    for (const fjell::TileRange& range : cut.mesh.tiles)
        draws[draws_++] = {.indexCount = range.index_count,
                           .instanceCount = 1,
                           .firstIndex = range.first_index,
                           .vertexOffset = 0,
                           .firstInstance = place_of(range.tile)};
}

void Drawer::copy_changes() const {
    const VkCommandBuffer commands = frame().commands;
#ifndef PLANT_NO_BARRIER
    // Frames before this one may still be reading what is about to be overwritten.
    barrier(commands, reads_vertices, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_COPY_BIT,
            VK_ACCESS_2_TRANSFER_WRITE_BIT);
#endif
    const auto copy = [&](const Buffer& to, const std::vector<VkBufferCopy>& runs) {
        if (!runs.empty())
            vkCmdCopyBuffer(commands, frame().staging.handle, to.handle, std::uint32_t(runs.size()), runs.data());
    };
    copy(vertices_, vertex_runs_);
    copy(indices_, index_runs_);
    barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, reads_vertices,
            VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_2_INDEX_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT |
                VK_ACCESS_2_TRANSFER_READ_BIT);
}

void Drawer::draw_ranges() const {
    const VkCommandBuffer commands = frame().commands;
    VkClearValue sky{}, far_away{}; // depth 0
    sky.color = {{0.1f, 0.21f, 0.44f, 1}};
    const auto attachment = [](const Image& image, VkImageLayout layout, VkClearValue clear) {
        return VkRenderingAttachmentInfo{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                         .imageView = image.view,
                                         .imageLayout = layout,
                                         .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                         .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                         .clearValue = clear};
    };
    const VkRenderingAttachmentInfo colour = attachment(frame().colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, sky);
    const VkRenderingAttachmentInfo depth =
        attachment(frame().depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, far_away);
    const VkRenderingInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                               .renderArea = {{0, 0}, size_},
                               .layerCount = 1,
                               .colorAttachmentCount = 1,
                               .pColorAttachments = &colour,
                               .pDepthAttachment = &depth};
    vkCmdBeginRendering(commands, &info);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &frame().set, 0, nullptr);
    const VkDeviceSize from = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &vertices_.handle, &from);
    vkCmdBindIndexBuffer(commands, indices_.handle, 0, index_bytes_ == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32);
    vkCmdDrawIndexedIndirect(commands, frame().draws.handle, 0, draws_, sizeof(VkDrawIndexedIndirectCommand));
    vkCmdEndRendering(commands);
}

VkCommandBuffer Drawer::record(const fjell::CutMesh& cut, const fjell::View& view, const Origin& origin) {
    write_block(cut, view, origin);
    write_draws(cut);
    const VkCommandBuffer commands = frame().commands;
    const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                         .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    must(vkBeginCommandBuffer(commands, &begin), "recording");
    copy_changes();
    change_layout(commands, frame().colour, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                  VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT, 0,
                  VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT);
    change_layout(commands, frame().depth, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                  VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT, 0, depth_tests,
                  VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT);
    draw_ranges();
    change_layout(commands, frame().colour, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
    change_layout(commands, frame().depth, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                  VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, depth_tests, VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                  VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
    return commands;
}

void Drawer::submit() {
    must(vkEndCommandBuffer(frame().commands), "recording");
    const VkCommandBufferSubmitInfo commands{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                             .commandBuffer = frame().commands};
    const VkSubmitInfo2 info{
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1, .pCommandBufferInfos = &commands};
    must(vkQueueSubmit2(gpu_.queue(), 1, &info, frame().done), "submitting");
}

void Drawer::finish() const {
    must(vkQueueWaitIdle(gpu_.queue()), "waiting for the device");
}

} // namespace vulkan
