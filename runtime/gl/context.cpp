#include "fjell/gl/context.h"

#include <map>
#include <mutex>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "gl/fail.h"

namespace fjell::gl {
namespace {

void on_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length, const GLchar* text, const void* user) {
    if (type != GL_DEBUG_TYPE_ERROR && severity != GL_DEBUG_SEVERITY_HIGH) return;
    // GL hands the pointer back as const; the log it was given as is not.
    auto& log = *static_cast<DebugLog*>(const_cast<void*>(user));
    ++log.errors;
    if (log.messages.size() < 64)
        log.messages.emplace_back(length < 0 ? std::string(text) : std::string(text, static_cast<std::size_t>(length)));
}

std::string egl_error_name() {
    switch (eglGetError()) {
    case EGL_SUCCESS: return "no reason given";
    case EGL_NOT_INITIALIZED: return "not initialised";
    case EGL_BAD_ALLOC: return "out of memory";
    case EGL_BAD_ACCESS: return "access denied";
    case EGL_BAD_MATCH: return "OpenGL 4.5 core is not supported";
    case EGL_BAD_ATTRIBUTE: return "an attribute is not supported";
    default: return "refused by the driver";
    }
}

// A 4.5 core context without a surface on a display that is already initialised, made current; null with a reason.
EGLContext start_context(EGLDisplay display, bool debug, std::string& reason) {
    if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) {
        reason = "no EGL_KHR_surfaceless_context";
        return EGL_NO_CONTEXT;
    }
    // Mask 0 for the surface type: any config will do, we render into framebuffer objects only.
    const EGLint config_wish[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!eglBindAPI(EGL_OPENGL_API) || !eglChooseConfig(display, config_wish, &config, 1, &count) || count == 0) {
        reason = "no desktop OpenGL";
        return EGL_NO_CONTEXT;
    }
    const EGLint wish[] = {EGL_CONTEXT_MAJOR_VERSION_KHR,
                           4,
                           EGL_CONTEXT_MINOR_VERSION_KHR,
                           5,
                           EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
                           EGL_CONTEXT_FLAGS_KHR,
                           debug ? EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR : 0,
                           EGL_NONE};
    const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, wish);
    if (context == EGL_NO_CONTEXT) {
        reason = egl_error_name();
        return EGL_NO_CONTEXT;
    }
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        reason = egl_error_name();
        eglDestroyContext(display, context);
        return EGL_NO_CONTEXT;
    }
    return context;
}

// EGL has one connection to a display, however often it is asked for: to end it for one context ends it for those of
// other threads, whose driver then finds no functions any more. So the last context of a display ends it.
struct Connections {
    std::mutex lock;
    std::map<EGLDisplay, int> contexts;
};
Connections& connections() {
    static Connections all;
    return all;
}

bool connect(EGLDisplay display) {
    Connections& all = connections();
    const std::scoped_lock hold(all.lock);
    if (!eglInitialize(display, nullptr, nullptr)) return false;
    ++all.contexts[display];
    return true;
}

void disconnect(EGLDisplay display) {
    Connections& all = connections();
    const std::scoped_lock hold(all.lock);
    if (--all.contexts[display] == 0) eglTerminate(display);
}

struct Started {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
};

Started try_display(EGLenum platform, void* native, bool debug, std::string& reason) {
    Started result;
    const EGLDisplay display = eglGetPlatformDisplayEXT(platform, native, nullptr);
    if (display == EGL_NO_DISPLAY || !connect(display)) {
        reason = egl_error_name();
        return result;
    }
    result.context = start_context(display, debug, reason);
    if (result.context != EGL_NO_CONTEXT)
        result.display = display;
    else
        disconnect(display);
    return result;
}

Started try_devices(const HeadlessOptions& options, std::string& reasons) {
    const bool enumerable = epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") ||
                            epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base");
    if (!enumerable || !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) {
        reasons += "; EGL devices: not supported";
        return {};
    }
    EGLDeviceEXT devices[32];
    EGLint count = 0;
    if (!eglQueryDevicesEXT(32, devices, &count) || count <= 0) {
        reasons += "; EGL devices: none";
        return {};
    }
    for (EGLint i = 0; i < count; ++i) {
        if (options.device >= 0 && options.device != i) continue;
        std::string reason;
        const Started started = try_display(EGL_PLATFORM_DEVICE_EXT, devices[i], options.debug, reason);
        if (started.context != EGL_NO_CONTEXT) return started;
        reasons += "; EGL device " + std::to_string(i) + ": " + reason;
    }
    if (options.device >= count) reasons += "; there are only " + std::to_string(count) + " EGL devices";
    return {};
}

} // namespace

void attach_debug_log(DebugLog& log) {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS); // the callback then runs on our thread, inside the faulty call
    glDebugMessageCallback(on_message, &log);
}

std::string describe_current() {
    const auto text = [](GLenum name) {
        const auto* value = glGetString(name);
        return std::string(value ? reinterpret_cast<const char*>(value) : "unknown");
    };
    return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

std::unique_ptr<Headless> Headless::create(const HeadlessOptions& options) {
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base"))
        fail("no headless OpenGL: EGL has no platform displays; install a driver (Debian: libegl-mesa0 "
             "libgl1-mesa-dri)");
    Started started;
    std::string reasons = "Mesa surfaceless: not tried";
    if (options.device < 0) {
        std::string reason = "not supported";
        if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
            started = try_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, options.debug, reason);
        reasons = "Mesa surfaceless: " + reason;
    }
    if (started.context == EGL_NO_CONTEXT) started = try_devices(options, reasons);
    if (started.context == EGL_NO_CONTEXT)
        fail("no headless OpenGL 4.5 core context (" + reasons +
             "); install a driver (Debian: libegl-mesa0 libgl1-mesa-dri)");
    std::unique_ptr<Headless> result(new Headless);
    result->display_ = started.display;
    result->context_ = started.context;
    attach_debug_log(*result->log_);
    return result;
}

Headless::~Headless() {
    if (display_ == nullptr) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    disconnect(display_);
}

bool Headless::make_current() {
    return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
}

std::string Headless::description() const {
    return describe_current();
}

} // namespace fjell::gl
