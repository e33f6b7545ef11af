#include "session/streamed.h"

#include <cstring>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "session/methods/method.h"

namespace fjell::session {

using io::Failure;

void StreamedPack::begin(const FlightOptions& options, Terrain& terrain, LiveCut cut) {
    StreamBudget budget = options.profile.stream_budget;
    budget.horizons = options.profile.light.shadows;
    budget.splat = options.layers && options.profile.layers.splat;
    memory_bytes_ = stream_bytes(file_->pack(), terrain, budget);
    memory_ = io::allocate(memory_bytes_);
    const Status s = create_stream(file_->pack(), terrain, cut, budget, {memory_.get(), memory_bytes_}, stream_);
    if (!s.ok())
        throw Failure(1, fmt::format("{}: {}: {} ([stream] of a --profile, where map_bytes is map_mb){}", options.pack,
                                     s.field, message(s.code), fewer_tiles(file_->pack().header, options.profile)));
    if (options.cold) file_->drop_cache();
    reader_ = std::make_unique<io::StreamReader>(
        stream_, *file_,
        io::StreamReaderOptions{options.read_mb_s * 1e6, options.read_latency_ms * 1e-3, budget.decoders});
}

const StreamReport& StreamedPack::update(std::span<const View> views, const CutSettings& cut,
                                         const StreamSettings& settings) {
    const Status s = update_stream(stream_, views, cut, settings, report_);
    if (!s.ok()) throw Failure(1, fmt::format("{}: {}", s.field, message(s.code)));
    for (const StreamFailure& failure : stream_failures(stream_)) tell(failure);
    return report_;
}

void StreamedPack::tell(const StreamFailure& failure) {
    const bool disk = failure.code == StatusCode::unreadable;
    const bool first = corrupt_ + unreadable_ == 0;
    ++(disk ? unreadable_ : corrupt_);
    if (!first || !listener_) return;
    const int error = reader_->counters().last_error;
    const char* const why = file_->changed()     ? "the file was changed after it was opened"
                            : disk && error != 0 ? std::strerror(error)
                                                 : message(failure.code);
    listener_(fmt::format("{}: {}: {}", file_->path(), io::chunk_name(failure.id), why));
}

} // namespace fjell::session
