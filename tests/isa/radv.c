#define _POSIX_C_SOURCE 200112L // setenv

#include "radv.h"

#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

enum { AMD = 0x1002, MOST_DEVICES = 16, KINDS = 4, BINDINGS_A_KIND = 16, MOST_STATISTICS = 64 };

struct radv {
    VkInstance instance;
    VkPhysicalDevice gpu;
    VkDevice device;
    VkDescriptorSetLayout set;
    VkPipelineLayout layout;
    PFN_vkGetPipelineExecutableStatisticsKHR statistics;
    PFN_vkGetPipelineExecutableInternalRepresentationsKHR representations;
    char driver[VK_MAX_DRIVER_INFO_SIZE];
};

static bool find_gpu(radv *r)
{
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_2};
    const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pApplicationInfo = &application};
    VkPhysicalDevice all[MOST_DEVICES];
    uint32_t count = MOST_DEVICES;
    if (vkCreateInstance(&info, NULL, &r->instance)) return false;
    if (vkEnumeratePhysicalDevices(r->instance, &count, all)) return false;
    for (uint32_t i = 0; i < count && !r->gpu; i++) {
        VkPhysicalDeviceDriverProperties driver = {
            .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
        VkPhysicalDeviceProperties2 p = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                         .pNext = &driver};
        vkGetPhysicalDeviceProperties2(all[i], &p);
        if (p.properties.vendorID != AMD || driver.driverID != VK_DRIVER_ID_MESA_RADV) continue;
        r->gpu = all[i];
        memcpy(r->driver, driver.driverInfo, sizeof r->driver);
    }
    return r->gpu;
}

static bool create_device(radv *r)
{
    static const char *const extension[] = {VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME};
    const float priority = 1;
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR report = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR};
    VkPhysicalDeviceFeatures2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                     .pNext = &report};
    vkGetPhysicalDeviceFeatures2(r->gpu, &all); // all that there is, so that any shader is legal
    all.features.robustBufferAccess = VK_FALSE; // as OpenGL is without asking for robustness
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = &all,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .enabledExtensionCount = 1,
                                     .ppEnabledExtensionNames = extension};
    if (vkCreateDevice(r->gpu, &info, NULL, &r->device)) return false;
    r->statistics = (PFN_vkGetPipelineExecutableStatisticsKHR)vkGetDeviceProcAddr(
        r->device, "vkGetPipelineExecutableStatisticsKHR");
    r->representations = (PFN_vkGetPipelineExecutableInternalRepresentationsKHR)vkGetDeviceProcAddr(
        r->device, "vkGetPipelineExecutableInternalRepresentationsKHR");
    return r->statistics && r->representations;
}

static bool create_layout(radv *r)
{
    static const VkDescriptorType kinds[KINDS] = {
        VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
        VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER};
    VkDescriptorSetLayoutBinding b[KINDS * BINDINGS_A_KIND];
    for (uint32_t i = 0; i < KINDS * BINDINGS_A_KIND; i++) {
        b[i] = (VkDescriptorSetLayoutBinding){i, kinds[i / BINDINGS_A_KIND], 1,
                                              VK_SHADER_STAGE_COMPUTE_BIT, NULL};
    }
    const VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = KINDS * BINDINGS_A_KIND,
        .pBindings = b};
    if (vkCreateDescriptorSetLayout(r->device, &set, NULL, &r->set)) return false;
    const VkPipelineLayoutCreateInfo layout = {.sType =
                                                   VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &r->set};
    return !vkCreatePipelineLayout(r->device, &layout, NULL, &r->layout);
}

radv *radv_open(const char *family)
{
    radv *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    setenv("RADV_FORCE_FAMILY", family, 1);
    if (find_gpu(r) && create_device(r) && create_layout(r)) return r;
    radv_close(r);
    return NULL;
}

const char *radv_driver(const radv *r)
{
    return r->driver;
}

void radv_close(radv *r)
{
    if (r->layout) vkDestroyPipelineLayout(r->device, r->layout, NULL);
    if (r->set) vkDestroyDescriptorSetLayout(r->device, r->set, NULL);
    if (r->device) vkDestroyDevice(r->device, NULL);
    if (r->instance) vkDestroyInstance(r->instance, NULL);
    free(r);
}

static bool read_statistics(radv *r, const VkPipelineExecutableInfoKHR *which, radv_code *code)
{
    const struct {
        const char *name;
        int *to;
    } wanted[] = {{"VGPRs", &code->vgprs},
                  {"SGPRs", &code->sgprs},
                  {"Spilled VGPRs", &code->spilled_vgprs},
                  {"Spilled SGPRs", &code->spilled_sgprs},
                  {"Scratch size", &code->scratch},
                  {"Subgroups per SIMD", &code->waves},
                  {"Code size", &code->bytes},
                  {"Latency", &code->latency}};
    const int count = (int)(sizeof wanted / sizeof *wanted);
    VkPipelineExecutableStatisticKHR s[MOST_STATISTICS];
    uint32_t all = MOST_STATISTICS;
    int found = 0;
    for (int i = 0; i < MOST_STATISTICS; i++) {
        s[i] = (VkPipelineExecutableStatisticKHR){
            .sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR};
    }
    if (r->statistics(r->device, which, &all, s)) return false;
    for (uint32_t i = 0; i < all; i++) {
        for (int k = 0; k < count; k++) {
            if (strcmp(s[i].name, wanted[k].name)) continue;
            *wanted[k].to = (int)s[i].value.u64;
            found++;
        }
    }
    return found == count;
}

static bool read_assembly(radv *r, const VkPipelineExecutableInfoKHR *which, radv_code *code)
{
    VkPipelineExecutableInternalRepresentationKHR text[MOST_STATISTICS];
    uint32_t all = MOST_STATISTICS;
    for (int i = 0; i < MOST_STATISTICS; i++) {
        text[i] = (VkPipelineExecutableInternalRepresentationKHR){
            .sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INTERNAL_REPRESENTATION_KHR};
    }
    if (r->representations(r->device, which, &all, text)) return false; // how long they are
    for (uint32_t i = 0; i < all; i++) {
        text[i].pData = strcmp(text[i].name, "Assembly") ? NULL : calloc(1, text[i].dataSize + 1);
        if (text[i].pData) code->assembly = text[i].pData;
    }
    return !r->representations(r->device, which, &all, text) && code->assembly;
}

bool radv_compile(radv *r, const uint32_t *spirv, size_t bytes, radv_code *code)
{
    const VkShaderModuleCreateInfo text = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = bytes, .pCode = spirv};
    VkShaderModule module = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
    memset(code, 0, sizeof *code);
    if (vkCreateShaderModule(r->device, &text, NULL, &module)) return false;
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR |
                 VK_PIPELINE_CREATE_CAPTURE_INTERNAL_REPRESENTATIONS_BIT_KHR,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main"},
        .layout = r->layout};
    bool good = !vkCreateComputePipelines(r->device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline);
    const VkPipelineExecutableInfoKHR which = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, .pipeline = pipeline};
    good = good && read_statistics(r, &which, code) && read_assembly(r, &which, code);
    vkDestroyPipeline(r->device, pipeline, NULL);
    vkDestroyShaderModule(r->device, module, NULL);
    return good;
}
