#include "gpu.h"

#include <cstdio>
#include <cstring>

#include <fjell/io/failure.h>

namespace vulkan {

namespace {

VKAPI_ATTR VkBool32 VKAPI_CALL heard(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                     const VkDebugUtilsMessengerCallbackDataEXT* data, void* count) {
    std::fprintf(stderr, "vulkan: %s\n", data->pMessage);
    ++*static_cast<std::uint32_t*>(count);
    return VK_FALSE;
}

bool has_debug_utils() {
    std::uint32_t count = 0;
    must(vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr), "listing Vulkan's extensions");
    std::vector<VkExtensionProperties> all(count);
    must(vkEnumerateInstanceExtensionProperties(nullptr, &count, all.data()), "listing Vulkan's extensions");
    for (const VkExtensionProperties& e : all)
        if (std::strcmp(e.extensionName, VK_EXT_DEBUG_UTILS_EXTENSION_NAME) == 0) return true;
    return false;
}

// What the drawer uses, and drivers of Vulkan 1.3 may lack.
bool suffices(VkPhysicalDevice device) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(device, &properties);
    if (properties.apiVersion < VK_API_VERSION_1_3) return false;
    VkPhysicalDeviceFeatures features;
    vkGetPhysicalDeviceFeatures(device, &features);
    return features.multiDrawIndirect && features.drawIndirectFirstInstance;
}

// no_family: there is none that draws and computes.
constexpr std::uint32_t no_family = 0xffffffff;
std::uint32_t family_of(VkPhysicalDevice device) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> all(count);
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, all.data());
    constexpr VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    for (std::uint32_t i = 0; i < count; ++i)
        if ((all[i].queueFlags & both) == both) return i;
    return no_family;
}

} // namespace

void must(VkResult result, const char* what) {
    if (result == VK_SUCCESS) return;
    throw fjell::io::Failure(3, std::string(what) + ": Vulkan answers " + std::to_string(result) +
                                    "; look at the driver, and at the memory of the device");
}

Gpu::Gpu() {
    try {
        make_instance();
        choose_device();
        make_device();
    } catch (...) { // the destructor of what was not made does not run
        for (; !ends_.empty(); ends_.pop_back()) ends_.back()();
        throw;
    }
}

Gpu::~Gpu() {
    (void)vkDeviceWaitIdle(device_);
    for (; !ends_.empty(); ends_.pop_back()) ends_.back()();
}

void Gpu::make_instance() {
    const VkApplicationInfo about{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    const VkDebugUtilsMessengerCreateInfoEXT listen{.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
                                                    .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                                                       VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                                                    .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                                                                   VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
                                                    .pfnUserCallback = heard,
                                                    .pUserData = &messages_};
    const char* const extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const bool listens = has_debug_utils();
    const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                    .pNext = listens ? &listen : nullptr, // of its own making and end too
                                    .pApplicationInfo = &about,
                                    .enabledExtensionCount = listens ? 1u : 0u,
                                    .ppEnabledExtensionNames = &extension};
    const VkResult made = vkCreateInstance(&info, nullptr, &instance_);
    if (made == VK_ERROR_INCOMPATIBLE_DRIVER) return; // no driver: choose_device() says so
    must(made, "starting Vulkan");
    at_end([this] { vkDestroyInstance(instance_, nullptr); });
    if (!listens) return;
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
    must(create(instance_, &listen, nullptr, &messenger), "listening to Vulkan's messages");
    at_end([this, destroy, messenger] { destroy(instance_, messenger, nullptr); });
}

void Gpu::choose_device() {
    std::uint32_t count = 0;
    if (instance_ != VK_NULL_HANDLE)
        must(vkEnumeratePhysicalDevices(instance_, &count, nullptr), "listing Vulkan's devices");
    std::vector<VkPhysicalDevice> all(count);
    if (count != 0) must(vkEnumeratePhysicalDevices(instance_, &count, all.data()), "listing Vulkan's devices");
    bool software = true;
    for (VkPhysicalDevice device : all) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(device, &properties);
        if (!suffices(device) || family_of(device) == no_family || (physical_ != VK_NULL_HANDLE && !software)) continue;
        software = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
        physical_ = device;
        name_ = properties.deviceName;
    }
    if (physical_ == VK_NULL_HANDLE)
        throw fjell::io::Failure(3, "no device of Vulkan 1.3 that draws indirectly; install a driver for the GPU, or "
                                    "one that needs none (mesa-vulkan-drivers)");
    queue_family_ = family_of(physical_);
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
}

void Gpu::make_device() {
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                        .queueFamilyIndex = queue_family_,
                                        .queueCount = 1,
                                        .pQueuePriorities = &priority};
    VkPhysicalDeviceVulkan13Features newer{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    newer.synchronization2 = VK_TRUE; // every device of Vulkan 1.3 has both
    newer.dynamicRendering = VK_TRUE;
    VkPhysicalDeviceFeatures features{};
    features.multiDrawIndirect = VK_TRUE;
    features.drawIndirectFirstInstance = VK_TRUE;
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .pNext = &newer,
                                  .queueCreateInfoCount = 1,
                                  .pQueueCreateInfos = &queue,
                                  .pEnabledFeatures = &features};
    must(vkCreateDevice(physical_, &info, nullptr, &device_), "opening the Vulkan device");
    at_end([this] { vkDestroyDevice(device_, nullptr); });
    vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
}

VkDeviceMemory Gpu::allocate(const VkMemoryRequirements& needs, Where where) {
    const VkMemoryPropertyFlags wanted =
        where == Where::device ? VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
                               : VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    std::uint32_t type = 0;
    while (type < memory_.memoryTypeCount &&
           ((needs.memoryTypeBits >> type & 1) == 0 || (memory_.memoryTypes[type].propertyFlags & wanted) != wanted))
        ++type; // Vulkan promises one of each
    const VkMemoryAllocateInfo info{
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size, .memoryTypeIndex = type};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    must(vkAllocateMemory(device_, &info, nullptr, &memory), "allocating the device's memory");
    at_end([this, memory] { vkFreeMemory(device_, memory, nullptr); });
    if (where == Where::device) device_bytes_ += needs.size;
    return memory;
}

Buffer Gpu::make_buffer(VkDeviceSize bytes, VkBufferUsageFlags usage, Where where) {
    const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = usage};
    Buffer buffer{.bytes = bytes};
    must(vkCreateBuffer(device_, &info, nullptr, &buffer.handle), "making a buffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device_, buffer.handle, &needs);
    const VkDeviceMemory memory = allocate(needs, where);
    at_end([this, handle = buffer.handle] { vkDestroyBuffer(device_, handle, nullptr); });
    must(vkBindBufferMemory(device_, buffer.handle, memory, 0), "making a buffer");
    if (where == Where::device) return buffer;
    void* mapped = nullptr;
    must(vkMapMemory(device_, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "mapping a buffer");
    buffer.mapped = static_cast<std::byte*>(mapped);
    std::memset(mapped, 0, bytes); // its pages are touched before the first frame
    return buffer;
}

Image Gpu::make_image(VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect, VkExtent2D size) {
    const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                 .imageType = VK_IMAGE_TYPE_2D,
                                 .format = format,
                                 .extent = {size.width, size.height, 1},
                                 .mipLevels = 1,
                                 .arrayLayers = 1,
                                 .samples = VK_SAMPLE_COUNT_1_BIT,
                                 .usage = usage};
    Image image;
    must(vkCreateImage(device_, &info, nullptr, &image.handle), "making an image");
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device_, image.handle, &needs);
    const VkDeviceMemory memory = allocate(needs, Where::device);
    at_end([this, handle = image.handle] { vkDestroyImage(device_, handle, nullptr); });
    must(vkBindImageMemory(device_, image.handle, memory, 0), "making an image");
    const VkImageViewCreateInfo view{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                     .image = image.handle,
                                     .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                     .format = format,
                                     .subresourceRange = {aspect, 0, 1, 0, 1}};
    must(vkCreateImageView(device_, &view, nullptr, &image.view), "making an image");
    at_end([this, handle = image.view] { vkDestroyImageView(device_, handle, nullptr); });
    return image;
}

VkShaderModule Gpu::make_shader(std::span<const std::uint32_t> code) {
    const VkShaderModuleCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code.size_bytes(), .pCode = code.data()};
    VkShaderModule shader = VK_NULL_HANDLE;
    must(vkCreateShaderModule(device_, &info, nullptr, &shader), "loading a shader");
    at_end([this, shader] { vkDestroyShaderModule(device_, shader, nullptr); });
    return shader;
}

} // namespace vulkan
