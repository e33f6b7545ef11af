#include "editor/scene/gpu_timer.h"

#include <epoxy/gl.h>

namespace fjell::editor {

void GpuTimer::begin() {
    Pair& pair = pairs_[next_];
    begun_ = !pair.waits;
    if (!begun_) return;
    if (pair.names[0] == 0) glCreateQueries(GL_TIMESTAMP, 2, pair.names);
    glQueryCounter(pair.names[0], GL_TIMESTAMP);
}

void GpuTimer::end() {
    if (!begun_) return;
    begun_ = false;
    glQueryCounter(pairs_[next_].names[1], GL_TIMESTAMP);
    pairs_[next_].waits = true;
    next_ = (next_ + 1) % frames;
}

double GpuTimer::take_us() {
    double us = -1;
    for (; pairs_[oldest_].waits; oldest_ = (oldest_ + 1) % frames) {
        Pair& pair = pairs_[oldest_];
        GLint there = 0;
        glGetQueryObjectiv(pair.names[1], GL_QUERY_RESULT_AVAILABLE, &there);
        if (there == 0) break;
        GLuint64 from = 0, to = 0;
        glGetQueryObjectui64v(pair.names[0], GL_QUERY_RESULT, &from);
        glGetQueryObjectui64v(pair.names[1], GL_QUERY_RESULT, &to);
        us = to > from ? static_cast<double>(to - from) * 1e-3 : 0;
        pair.waits = false;
    }
    return us;
}

void GpuTimer::drop_graphics() {
    for (Pair& pair : pairs_)
        if (pair.names[0] != 0) glDeleteQueries(2, pair.names);
    *this = {};
}

} // namespace fjell::editor
