// An OpenGL 4.5 core context without a window, through EGL. A host that has a context does not need this.
//
// Ownership: the object owns its context. Everything that was made in it (Target, Renderer) must be destroyed first,
// while the context is current. Thread: a context is current on one thread at a time; create() makes it current on the
// calling thread. Failure: create() throws io::Failure, 3, with one line that says what to do. Nothing aborts.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "fjell/export.h"
#include "fjell/io/failure.h"

FJELL_API_BEGIN
namespace fjell::gl {

// What KHR_debug reported. Only errors and messages of high severity are kept, the first 64 of them as text.
struct DebugLog {
    std::uint64_t errors = 0;
    std::vector<std::string> messages;
};

// Which context to make.
struct HeadlessOptions {
    bool debug = false; // a debug context: GL errors are logged, which costs some speed
    // -1: Mesa's surfaceless platform, then every EGL device. n >= 0: the n-th EGL device only.
    int device = -1;
};

// A context without a window, for tools and tests.
class Headless {
public:
    [[nodiscard]] static std::unique_ptr<Headless> create(const HeadlessOptions& options = {});
    ~Headless();
    Headless(const Headless&) = delete;
    Headless& operator=(const Headless&) = delete;

    [[nodiscard]] bool make_current();
    // Name and version of the driver, for reports.
    [[nodiscard]] std::string description() const;
    [[nodiscard]] const DebugLog& log() const { return *log_; }

private:
    Headless() = default;
    void* display_ = nullptr; // EGLDisplay
    void* context_ = nullptr; // EGLContext
    std::unique_ptr<DebugLog> log_ = std::make_unique<DebugLog>();
};

// Sends the current context's messages to `log`, which must outlive the context.
void attach_debug_log(DebugLog& log);
// "renderer, version" of the current context.
[[nodiscard]] std::string describe_current();

} // namespace fjell::gl
FJELL_API_END
