#include "fjell/io/journal.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#define XXH_INLINE_ALL // as runtime/src/shared/hash.cpp does
#include <xxhash.h>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/system.h"

namespace fjell::io {

namespace {

constexpr char journal_magic[8] = {'F', 'J', 'E', 'L', 'L', 'J', 'N', '\n'};
constexpr std::uint32_t journal_version = 1;

enum Kind : std::uint32_t {
    set_layer_record = 1, // which is new if its id is
    remove_layer_record,
    add_stamps_record,
    remove_stamps_record
};

// Before each payload. Records begin at multiples of 8, so that the next one can be looked for.
struct RecordHead {
    char magic[4];
    std::uint32_t kind;
    std::uint64_t sequence, bytes; // of the payload, without the zeros up to a multiple of 8
    std::uint64_t hash;            // XXH3 of the payload, seeded with what is before
};
static_assert(sizeof(RecordHead) == 32, "a journal's records are stored: change journal_version with them");
constexpr char record_magic[4] = {'F', 'J', 'r', '1'};

std::uint64_t hash_of(const RecordHead& head, std::span<const std::byte> payload) {
    return XXH3_64bits_withSeed(payload.data(), payload.size(), XXH3_64bits(&head, offsetof(RecordHead, hash)));
}
constexpr std::uint64_t padded(std::uint64_t bytes) {
    return (bytes + 7) & ~std::uint64_t{7};
}

// What a payload is made of, in order.
class PayloadWriter {
public:
    template <typename T>
    void operator()(const T& value) {
        raw({reinterpret_cast<const std::byte*>(&value), sizeof value});
    }
    template <typename T>
    void list(const std::vector<T>& values) {
        (*this)(static_cast<std::uint64_t>(values.size()));
        raw(std::as_bytes(std::span(values)));
    }
    void text(const std::string& value) {
        (*this)(static_cast<std::uint64_t>(value.size()));
        raw(std::as_bytes(std::span(value)));
    }
    std::vector<std::byte> bytes;

private:
    void raw(std::span<const std::byte> more) { bytes.insert(bytes.end(), more.begin(), more.end()); }
};

class PayloadReader {
public:
    explicit PayloadReader(std::span<const std::byte> bytes) : left_(bytes) {}
    template <typename T>
    void operator()(T& value) {
        const std::span<const std::byte> from = take(1, sizeof value);
        std::memcpy(&value, from.data(), sizeof value);
    }
    template <typename T>
    void list(std::vector<T>& values) {
        std::uint64_t count = 0;
        (*this)(count);
        const std::span<const std::byte> from = take(count, sizeof(T));
        values.resize(static_cast<std::size_t>(count));
        if (!from.empty()) std::memcpy(values.data(), from.data(), from.size());
    }
    void text(std::string& value) {
        std::vector<char> characters;
        list(characters);
        value.assign(characters.begin(), characters.end());
    }
    [[nodiscard]] std::span<const std::byte> left() const { return left_; }

private:
    std::span<const std::byte> take(std::uint64_t count, std::size_t size) {
        if (count > left_.size() / size) throw Failure(1, "is too short");
        const std::span<const std::byte> taken = left_.first(static_cast<std::size_t>(count) * size);
        left_ = left_.subspan(taken.size());
        return taken;
    }
    std::span<const std::byte> left_;
};

// One for both directions. A new field comes last, with a new journal_version.
template <typename Archive, typename AnyStamp>
void each_field(Archive& archive, AnyStamp& s) {
    archive(s.shape), archive(s.x_m), archive(s.z_m), archive(s.radius_m), archive(s.falloff_m), archive(s.amount_m);
    archive(s.height_m), archive(s.slope_x), archive(s.slope_z), archive(s.wavelength_m), archive(s.seed);
    archive(s.first.column), archive(s.first.row), archive(s.columns), archive(s.rows), archive(s.morph_s);
    archive(s.strength), archive(s.rgb[0]), archive(s.rgb[1]), archive(s.rgb[2]), archive(s.material);
}
static_assert(sizeof(Stamp) == 120, "a stamp has another field: write it down in each_field()");

void put(PayloadWriter& to, const KeptStamp& stamp) {
    each_field(to, stamp.plain);
    to.list(stamp.points), to.list(stamp.heights_m), to.list(stamp.mask);
}
void get(PayloadReader& from, KeptStamp& stamp) {
    each_field(from, stamp.plain);
    from.list(stamp.points), from.list(stamp.heights_m), from.list(stamp.mask);
}

// Whether push_stamp() takes it, and its lists have the lengths that it reads.
void check(const KeptStamp& kept) {
    const Stamp stamp = kept.stamp();
    if (const Status status = check_stamp(stamp); !status.ok())
        throw Failure(1, std::string(status.field) + ": " + message(status.code));
    const auto samples = static_cast<std::uint64_t>(stamp.columns) * static_cast<std::uint64_t>(stamp.rows);
    const auto fits = [&](std::size_t count) { return count == 0 || count == samples; };
    if (!fits(kept.heights_m.size())) throw Failure(1, "Stamp::heights_m: one number a sample of its rectangle");
    if (!fits(kept.mask.size())) throw Failure(1, "Stamp::mask: one number a sample of its rectangle");
}

void check(const JournalLayer& layer) {
    if (layer.name.empty() || layer.name.size() > max_layer_name)
        throw Failure(1, "a layer's name has 1 to " + std::to_string(max_layer_name) + " bytes");
    if (!(layer.strength >= 0 && layer.strength <= 1)) throw Failure(1, "a layer's strength is 0 to 1");
}

std::vector<std::byte> layer_payload(const JournalLayer& layer, std::uint64_t place) {
    PayloadWriter to;
    to(layer.id), to(static_cast<std::uint32_t>(layer.on)), to(layer.strength), to(place), to.text(layer.name);
    return to.bytes;
}
std::vector<std::byte> stamps_payload(std::uint32_t layer, std::uint64_t first, std::span<const KeptStamp> stamps) {
    PayloadWriter to;
    to(layer), to(first), to(static_cast<std::uint64_t>(stamps.size()));
    for (const KeptStamp& stamp : stamps) put(to, stamp);
    return to.bytes;
}

void append_record(std::vector<std::byte>& to, std::uint32_t kind, std::uint64_t sequence,
                   std::span<const std::byte> payload) {
    RecordHead head{{}, kind, sequence, payload.size(), 0};
    std::memcpy(head.magic, record_magic, sizeof record_magic);
    head.hash = hash_of(head, payload);
    const auto bytes = std::as_bytes(std::span(&head, 1));
    to.insert(to.end(), bytes.begin(), bytes.end());
    to.insert(to.end(), payload.begin(), payload.end());
    to.resize(static_cast<std::size_t>(padded(to.size())));
}

// The record at the beginning of `bytes`; its payload, or nothing if there is none that is whole.
std::span<const std::byte> record_at(std::span<const std::byte> bytes, RecordHead& head) {
    if (bytes.size() < sizeof head) return {};
    std::memcpy(&head, bytes.data(), sizeof head);
    if (std::memcmp(head.magic, record_magic, sizeof record_magic) != 0) return {};
    const std::uint64_t room = bytes.size() - sizeof head;
    if (head.bytes == 0 || head.bytes > room || padded(head.bytes) > room) return {};
    const std::span<const std::byte> payload = bytes.subspan(sizeof head, static_cast<std::size_t>(head.bytes));
    return hash_of(head, payload) == head.hash ? payload : std::span<const std::byte>();
}

} // namespace

KeptStamp::KeptStamp(const Stamp& stamp) : plain(stamp) {
    plain.points = nullptr, plain.heights_m = nullptr, plain.mask = nullptr, plain.point_count = 0;
    const std::size_t samples = static_cast<std::size_t>(stamp.columns) * static_cast<std::size_t>(stamp.rows);
    if (stamp.points != nullptr) points.assign(stamp.points, stamp.points + stamp.point_count);
    if (stamp.heights_m != nullptr) heights_m.assign(stamp.heights_m, stamp.heights_m + samples);
    if (stamp.mask != nullptr) mask.assign(stamp.mask, stamp.mask + samples);
}

Stamp KeptStamp::stamp() const {
    Stamp stamp = plain;
    stamp.points = points.empty() ? nullptr : points.data();
    stamp.point_count = static_cast<std::uint32_t>(points.size());
    stamp.heights_m = heights_m.empty() ? nullptr : heights_m.data();
    stamp.mask = mask.empty() ? nullptr : mask.data();
    return stamp;
}

std::string journal_path(const std::string& pack) {
    std::string name = pack;
    while (name.size() > 1 && name.ends_with('/')) name.pop_back(); // a set's folder
    return name + ".journal";
}

bool is_journal(const std::string& path) {
    const int fd = os::open_to_read(path);
    if (fd < 0) return false;
    char magic[sizeof journal_magic] = {};
    const bool read = os::read_at(fd, 0, std::as_writable_bytes(std::span(magic))) == 0;
    (void)os::close_file(fd);
    return read && std::memcmp(magic, journal_magic, sizeof magic) == 0;
}

Journal::Head Journal::head_for(const PackHeader& pack) {
    Head head{};
    std::memcpy(head.magic, journal_magic, sizeof journal_magic);
    head.version = journal_version, head.head_bytes = sizeof head;
    head.pack_hash = pack.directory_hash;
    head.columns = pack.columns, head.rows = pack.rows;
    for (int axis = 0; axis < 2; ++axis) {
        head.spacing_m[axis] = pack.spacing_m[axis];
        head.crs_origin[axis] = pack.crs_origin[axis], head.crs_step[axis] = pack.crs_step[axis];
    }
    head.hash = XXH3_64bits(&head, offsetof(Head, hash));
    return head;
}

Journal::Journal(const std::string& path) : path_(path) {
    const int fd = open_regular_file(path);
    try {
        read(fd);
    } catch (...) {
        (void)os::close_file(fd);
        throw;
    }
    (void)os::close_file(fd);
}

Journal::Journal(const std::string& path, const PackHeader& pack, JournalAccess access) : path_(path) {
    head_ = head_for(pack);
    os::FileInfo there;
    if (access == JournalAccess::extend && !os::look(path, there)) {
        AtomicFile file(path); // whole or not at all
        file.write(std::as_bytes(std::span(&head_, 1)));
        file.commit();
    }
    if (access == JournalAccess::extend) {
        open_alone();
        refuse_other_pack(pack);
        return;
    }
    const Journal existing(path);
    existing.refuse_other_pack(pack);
    head_ = existing.head_, layers_ = existing.layers_;
    next_layer_ = existing.next_layer_, next_stamp_ = existing.next_stamp_;
    sequence_ = existing.sequence_, bytes_ = existing.bytes_, dropped_ = existing.dropped_;
}

Journal::~Journal() {
    if (fd_ >= 0) (void)os::close_file(fd_);
}

void Journal::open_alone() {
    fd_ = os::open_to_extend(path_);
    if (fd_ < 0 && errno == EBUSY)
        throw Failure(1, path_ + ": another program is changing it; close that, or copy the journal");
    if (fd_ < 0) disk_failure(path_, "open");
    try {
        read(fd_);
        if (dropped_ != 0)
            if (const int error = os::cut_to(fd_, bytes_); error != 0) errno = error, disk_failure(path_, "shorten");
    } catch (...) {
        (void)os::close_file(std::exchange(fd_, -1));
        throw;
    }
}

void Journal::read(int fd) {
    os::FileInfo info;
    if (!os::look(fd, info)) disk_failure(path_, "read");
    std::vector<std::byte> file(static_cast<std::size_t>(info.bytes));
    read_all(fd, 0, file, path_);
    const auto refuse = [&](const std::string& what) { throw Failure(1, path_ + ": " + what); };
    if (file.size() < sizeof head_ || std::memcmp(file.data(), journal_magic, sizeof journal_magic) != 0)
        refuse("is no journal of Fjell");
    std::memcpy(&head_, file.data(), sizeof head_);
    if (head_.version > journal_version)
        refuse("is of a newer version of Fjell (" + std::to_string(head_.version) + "; this one reads " +
               std::to_string(journal_version) + ")");
    if (head_.version == 0 || head_.head_bytes != sizeof head_ ||
        head_.hash != XXH3_64bits(&head_, offsetof(Head, hash)))
        refuse("its first bytes are damaged; take a copy of it");
    read_records(file);
}

void Journal::read_records(std::span<const std::byte> file) {
    std::size_t at = sizeof head_;
    while (at < file.size()) {
        RecordHead head{};
        const std::span<const std::byte> payload = record_at(file.subspan(at), head);
        if (payload.empty() || head.sequence != sequence_) break;
        try {
            apply(head.kind, payload);
        } catch (const Failure& failure) { // the checksum is right, so a program wrote it so
            throw Failure(1, path_ + ": record " + std::to_string(sequence_) + ": " + failure.what());
        }
        ++sequence_;
        at += sizeof head + static_cast<std::size_t>(padded(head.bytes));
    }
    bytes_ = at, dropped_ = file.size() - at;
    // A program that is killed leaves part of one record, at the end. Whole ones after it: something else has happened.
    for (std::size_t later = at + 8; later + sizeof(RecordHead) <= file.size(); later += 8) {
        RecordHead head{};
        if (!record_at(file.subspan(later), head).empty())
            throw Failure(1, path_ + ": is damaged in record " + std::to_string(sequence_) + ", at byte " +
                                 std::to_string(at) + " of " + std::to_string(file.size()) +
                                 ", with whole records after it; take a copy of it, or cut it off there (truncate -s " +
                                 std::to_string(at) + ")");
    }
}

void Journal::refuse_other_pack(const PackHeader& pack) const {
    if (head_.pack_hash == pack.directory_hash) return;
    throw Failure(1, path_ + ": belongs to another pack, or to this one before it was baked anew; carry it over with: "
                             "fjell-bake rebase JOURNAL PACK -o NEW");
}

JournalLayer* Journal::find_layer(std::uint32_t id) {
    const auto found = std::ranges::find(layers_, id, &JournalLayer::id);
    return found != layers_.end() ? &*found : nullptr;
}
JournalLayer& Journal::layer_of(std::uint32_t id) {
    JournalLayer* const layer = find_layer(id);
    if (layer == nullptr) throw Failure(1, "no layer " + std::to_string(id));
    return *layer;
}

// All is checked before anything changes.
void Journal::apply(std::uint32_t kind, std::span<const std::byte> payload) {
    PayloadReader from(payload);
    JournalLayer layer;
    std::uint32_t on = 0;
    std::uint64_t place = 0;
    std::vector<std::uint64_t> ids;
    const auto must_end = [&] {
        if (!from.left().empty()) throw Failure(1, "is too long");
    };
    switch (kind) {
    case set_layer_record: {
        from(layer.id), from(on), from(layer.strength), from(place), from.text(layer.name);
        must_end(), check(layer);
        layer.on = on != 0;
        JournalLayer* const there = find_layer(layer.id);
        if (place > layers_.size() - (there != nullptr ? 1 : 0) || layer.id == 0)
            throw Failure(1, "a layer's place is below " + std::to_string(layers_.size()));
        if (there == nullptr && layers_.size() == max_journal_layers)
            throw Failure(1, "a journal has at most " + std::to_string(max_journal_layers) + " layers");
        if (there != nullptr) {
            layer.stamps = std::move(there->stamps);
            layers_.erase(layers_.begin() + (there - layers_.data()));
        }
        next_layer_ = std::max(next_layer_, layer.id + 1);
        layers_.insert(layers_.begin() + static_cast<std::ptrdiff_t>(place), std::move(layer));
        return;
    }
    case remove_layer_record:
        from(layer.id), must_end();
        layers_.erase(layers_.begin() + (&layer_of(layer.id) - layers_.data()));
        return;
    case add_stamps_record: {
        std::uint64_t first = 0, count = 0;
        from(layer.id), from(first), from(count);
        for (std::uint64_t i = 0; i < count; ++i) {
            JournalStamp& stamp = layer.stamps.emplace_back();
            stamp.id = first + i;
            get(from, stamp.what);
            check(stamp.what);
        }
        must_end();
        JournalLayer& to = layer_of(layer.id);
        if (first < next_stamp_) throw Failure(1, "stamp " + std::to_string(first) + " is there already");
        next_stamp_ = first + count;
        std::ranges::move(layer.stamps, std::back_inserter(to.stamps));
        return;
    }
    case remove_stamps_record: {
        from.list(ids), must_end();
        std::ranges::sort(ids);
        if (std::ranges::adjacent_find(ids) != ids.end()) throw Failure(1, "a stamp is named twice");
        const auto is_named = [&](const JournalStamp& s) { return std::ranges::binary_search(ids, s.id); };
        std::size_t found = 0;
        for (const JournalLayer& of : layers_)
            found += static_cast<std::size_t>(std::ranges::count_if(of.stamps, is_named));
        if (found != ids.size()) throw Failure(1, "a stamp that is to be removed is not there");
        for (JournalLayer& of : layers_) std::erase_if(of.stamps, is_named);
        return;
    }
    default: throw Failure(1, "is of a kind that this version of Fjell does not know");
    }
}

void Journal::record(std::uint32_t kind, std::vector<std::byte> payload) {
    if (fd_ < 0) throw Failure(1, path_ + ": is open to be read only");
    if (broken_) throw Failure(3, path_ + ": could not be written before; open it again");
    std::vector<std::byte> bytes;
    append_record(bytes, kind, sequence_, payload);
    if (const int error = os::write_at(fd_, bytes_, bytes); error != 0) {
        broken_ = os::cut_to(fd_, bytes_) != 0; // an incomplete record, which opening drops
        errno = error;
        disk_failure(path_, "write");
    }
    try {
        apply(kind, payload);
    } catch (const Failure& failure) {
        broken_ = os::cut_to(fd_, bytes_) != 0;
        throw Failure(1, path_ + ": " + failure.what());
    }
    bytes_ += bytes.size();
    ++sequence_;
}

std::vector<KeptStamp> Journal::stamps(std::size_t most_layers) const {
    std::vector<KeptStamp> all;
    for (const JournalLayer& layer : layers().first(std::min(most_layers, layers_.size()))) {
        if (!layer.on || layer.strength == 0) continue;
        for (const JournalStamp& stamp : layer.stamps) {
            all.push_back(stamp.what);
            all.back().plain.strength *= layer.strength;
        }
    }
    return all;
}

std::uint32_t Journal::add_layer(const std::string& name) {
    const JournalLayer layer{next_layer_, name, true, 1, {}};
    record(set_layer_record, layer_payload(layer, layers_.size()));
    return layer.id;
}

void Journal::set_layer(const JournalLayer& layer, std::size_t place) {
    if (find_layer(layer.id) == nullptr) throw Failure(1, path_ + ": no layer " + std::to_string(layer.id));
    record(set_layer_record, layer_payload(layer, place));
}

void Journal::remove_layer(std::uint32_t id) {
    PayloadWriter to;
    to(id);
    record(remove_layer_record, std::move(to.bytes));
}

std::uint64_t Journal::add_stamps(std::uint32_t layer, std::span<const KeptStamp> stamps) {
    const std::uint64_t first = next_stamp_;
    if (!stamps.empty()) record(add_stamps_record, stamps_payload(layer, first, stamps));
    return first;
}

void Journal::remove_stamps(std::span<const std::uint64_t> ids) {
    if (ids.empty()) return;
    PayloadWriter to;
    to.list(std::vector<std::uint64_t>(ids.begin(), ids.end()));
    record(remove_stamps_record, std::move(to.bytes));
}

void Journal::commit() {
    if (fd_ < 0) throw Failure(1, path_ + ": is open to be read only");
    if (const int error = os::flush(fd_); error != 0) errno = error, disk_failure(path_, "flush");
}

// Head, layers, then their stamps; ids stay.
std::vector<std::byte> Journal::whole_file() const {
    std::vector<std::byte> bytes(sizeof head_);
    std::memcpy(bytes.data(), &head_, sizeof head_);
    std::uint64_t sequence = 0;
    for (std::size_t place = 0; place < layers_.size(); ++place)
        append_record(bytes, set_layer_record, sequence++, layer_payload(layers_[place], place));
    // Ids rise along the file.
    std::vector<std::pair<const JournalStamp*, std::uint32_t>> stamps;
    for (const JournalLayer& layer : layers_)
        for (const JournalStamp& stamp : layer.stamps) stamps.emplace_back(&stamp, layer.id);
    std::ranges::sort(stamps, {}, [](const auto& s) { return s.first->id; });
    for (std::size_t i = 0; i < stamps.size();) { // as many a record as follow each other in one layer
        const auto [first, layer] = stamps[i];
        std::vector<KeptStamp> together;
        for (; i < stamps.size() && stamps[i].second == layer && stamps[i].first->id == first->id + together.size();
             ++i)
            together.push_back(stamps[i].first->what);
        append_record(bytes, add_stamps_record, sequence++, stamps_payload(layer, first->id, together));
    }
    return bytes;
}

std::uint64_t Journal::dead_bytes() const {
    const std::uint64_t alive = whole_file().size();
    return bytes_ > alive ? bytes_ - alive : 0;
}

void Journal::compact() {
    if (fd_ < 0) throw Failure(1, path_ + ": is open to be read only");
    AtomicFile file(path_);
    file.write(whole_file());
    (void)os::close_file(std::exchange(fd_, -1)); // Windows replaces no file that is open so
    file.commit();
    const auto [next_layer, next_stamp] = std::pair(next_layer_, next_stamp_); // ids that have gone stay so
    layers_.clear();
    next_layer_ = 1, next_stamp_ = 1, sequence_ = 0;
    broken_ = false;
    open_alone();
    next_layer_ = next_layer, next_stamp_ = next_stamp;
}

namespace {

// A journal's place in another pack: so many samples east and south.
std::int32_t samples_between(double from, double to, double step, const char* axis, const std::string& path) {
    const double samples = (from - to) / step, nearest = std::round(samples);
    if (!(std::abs(samples - nearest) < 1e-3) || !(std::abs(nearest) <= double{max_columns}))
        throw Failure(1, path + ": the packs lie " + std::to_string(samples) + " samples apart along " + axis +
                             ", not a whole number of them; bake the new one on the old one's grid");
    return static_cast<std::int32_t>(nearest);
}

} // namespace

void rebase_journal(const std::string& from, const PackHeader& pack, const std::string& to) {
    Journal old(from);
    const Journal::Head& head = old.head_;
    std::int32_t shift[2] = {};
    for (int axis = 0; axis < 2; ++axis) {
        if (std::abs(head.spacing_m[axis] - pack.spacing_m[axis]) > 1e-9 * pack.spacing_m[axis])
            throw Failure(1, from + ": its pack has a sample every " + std::to_string(head.spacing_m[axis]) +
                                 " m, the new one every " + std::to_string(pack.spacing_m[axis]) +
                                 " m; rebase takes packs of one spacing");
        // Rows go south, against the CRS' second axis.
        const double step = pack.crs_step[axis] > 0 ? pack.crs_step[axis] : pack.spacing_m[axis];
        shift[axis] = samples_between(head.crs_origin[axis], pack.crs_origin[axis], axis == 0 ? step : -step,
                                      axis == 0 ? "x" : "y", from);
    }
    for (JournalLayer& layer : old.layers_)
        for (JournalStamp& stamp : layer.stamps) {
            const double by_x_m = shift[0] * pack.spacing_m[0], by_z_m = shift[1] * pack.spacing_m[1];
            Stamp& plain = stamp.what.plain;
            plain.x_m += by_x_m, plain.z_m += by_z_m;
            plain.first = plain.first + SampleIndex{shift[0], shift[1]};
            for (StampPoint& point : stamp.what.points) point.x_m += by_x_m, point.z_m += by_z_m;
        }
    old.head_ = Journal::head_for(pack);
    AtomicFile file(to);
    file.write(old.whole_file());
    file.commit();
}

} // namespace fjell::io
