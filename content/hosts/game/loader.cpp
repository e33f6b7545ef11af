#include "loader.h"

#include <span>

namespace game {

void Loader::run() {
    while (!stop_) {
        const std::uint32_t seen = wakes_; // read first: a wake() from here on ends the wait below
        fjell::StreamRequest request;
        if (fjell::stream_next_request(stream_, request))
            serve(request);
        else
            wakes_.wait(seen);
    }
}

void Loader::serve(const fjell::StreamRequest& request) {
    if (!fjell::stream_still_wanted(stream_, request.ticket)) { // the camera has moved on
        (void)fjell::stream_fail(stream_, request.ticket, true);
        return;
    }
    bytes_.resize(request.bytes);
    if (file_.read(request.offset, bytes_))
        (void)fjell::stream_provide(stream_, request.ticket, bytes_); // damaged bytes are the stream's to report
    else
        (void)fjell::stream_fail(stream_, request.ticket);
}

void Loader::wake() {
    ++wakes_;
    wakes_.notify_one(); // enters the kernel only if the loader sleeps
}

Loader::~Loader() {
    stop_ = true;
    wake();
    thread_.join();
}

} // namespace game
