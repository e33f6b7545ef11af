#include "io/pack_stream.h"

#include <cerrno>
#include <cstring>
#include <string_view>

#include "fjell/io/failure.h"

namespace fjell::io {

namespace {

// What map_bytes has to hold is no mesh, and its field says what it is.
const char* why(const Status& status) {
    if (status.code == StatusCode::budget_too_small &&
        std::string_view(status.field).find("mips") != std::string_view::npos)
        return "raise the field, or lower StreamBudget::tail_log2";
    return message(status.code);
}

} // namespace

void PackStream::begin(const Terrain& terrain, LiveCut cut, const StreamBudget& budget,
                       const StreamReaderOptions& options) {
    memory_bytes_ = stream_bytes(*pack_, terrain, budget);
    memory_ = allocate(memory_bytes_);
    if (const Status s = create_stream(*pack_, terrain, cut, budget, {memory_.get(), memory_bytes_}, stream_); !s.ok())
        throw Failure(1, name_ + ": " + s.field + ": " + why(s));
    if (file_) {
        reader_ = std::make_unique<StreamReader>(stream_, *file_, options);
        return;
    }
    const std::span bytes = pack_->bytes;
    const auto copy = [bytes](std::uint64_t offset, std::span<std::byte> to) {
        if (offset > bytes.size() || to.size() > bytes.size() - offset) return EIO;
        std::memcpy(to.data(), bytes.data() + offset, to.size());
        return 0;
    };
    reader_ = std::make_unique<StreamReader>(stream_, copy, options);
}

const StreamReport& PackStream::update(std::span<const View> views, const CutSettings& cut,
                                       const StreamSettings& settings) {
    if (const Status s = update_stream(stream_, views, cut, settings, report_); !s.ok())
        throw Failure(1, std::string(s.field) + ": " + message(s.code));
    for (const StreamFailure& failure : stream_failures(stream_)) {
        if (corrupt_ + unreadable_ == 0) first_ = failure;
        ++(failure.code == StatusCode::unreadable ? unreadable_ : corrupt_);
    }
    return report_;
}

std::string PackStream::first_failure() const {
    if (corrupt_ + unreadable_ == 0) return {};
    const int error = reader_->counters().last_error;
    const char* const reason = file_ && file_->changed() ? "the file was changed after it was opened"
                               : first_.code == StatusCode::unreadable && error != 0 ? std::strerror(error)
                                                                                     : message(first_.code);
    return name_ + ": " + chunk_name(first_.id) + ": " + reason;
}

} // namespace fjell::io
