// A Vulkan 1.3 device without a window, and what is made on it.
//
// Ownership: what a Gpu makes ends with it, in the other order. Thread: one. Failure: io::Failure with exit code 3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

namespace vulkan {

// Throws what it means that this did not succeed.
void must(VkResult result, const char* what);

struct Buffer {
    VkBuffer handle = VK_NULL_HANDLE;
    VkDeviceSize bytes = 0;
    std::byte* mapped = nullptr; // of Where::host: for good
};
struct Image {
    VkImage handle = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
};
enum class Where : std::uint8_t { device, host }; // host: mapped and coherent

class Gpu {
public:
    // The first device with what the host needs; one that is no software before one that is.
    Gpu();
    ~Gpu();
    Gpu(const Gpu&) = delete;
    Gpu& operator=(const Gpu&) = delete;

    [[nodiscard]] VkDevice device() const { return device_; }
    [[nodiscard]] VkQueue queue() const { return queue_; }
    [[nodiscard]] std::uint32_t queue_family() const { return queue_family_; }
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] std::uint64_t device_bytes() const { return device_bytes_; } // of buffers and images there
    // What the validation layer has said, if VK_INSTANCE_LAYERS has switched it on; each line went to stderr too.
    [[nodiscard]] std::uint32_t messages() const { return messages_; }

    [[nodiscard]] Buffer make_buffer(VkDeviceSize bytes, VkBufferUsageFlags usage, Where where);
    [[nodiscard]] Image make_image(VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect,
                                   VkExtent2D size);
    [[nodiscard]] VkShaderModule make_shader(std::span<const std::uint32_t> code);
    void at_end(std::function<void()> end) { ends_.push_back(std::move(end)); }

private:
    void make_instance();
    void choose_device();
    void make_device();
    [[nodiscard]] VkDeviceMemory allocate(const VkMemoryRequirements& needs, Where where);

    std::vector<std::function<void()>> ends_;
    std::uint32_t messages_ = 0;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::uint32_t queue_family_ = 0;
    std::uint64_t device_bytes_ = 0;
    std::string name_;
    VkPhysicalDeviceMemoryProperties memory_{};
};

} // namespace vulkan
