// Ground that lasts: stamps (fjell/edit.h) in layers, in a file beside the pack that they change.
//
// The pack stays as it was baked. The journal keeps what has been done to its ground. Stamps lie in *layers*, from the
// bottom to the top. A layer can be switched off, weakened and moved, so what a stamp has done can always be taken
// back. `stamps()` gives what is to be applied, in order. `fjell-fly --edits`, `fjell-bake --edits` and Python read the
// file as they read stamps in JSON.
//
// The file is append-only: each change is a record at its end, with a checksum. A change is *confirmed* when commit()
// has returned. A program that is killed, at whatever byte, loses none that is confirmed; an incomplete record at the
// end is dropped when the file is opened again (dropped_bytes()). compact() writes only what still counts.
// A journal belongs to one pack, by the hash that names its content, and is refused with any other. rebase_journal()
// carries it over to another bake of the same ground.
//
// Example:
//     fjell::io::Journal journal(fjell::io::journal_path(path), changing.pack().header);
//     const std::uint32_t layer = journal.layers().empty() ? journal.add_layer("digging") : journal.layers()[0].id;
//     journal.add_stamp(layer, fjell::io::KeptStamp(crater));
//     journal.commit();
//
// Memory: all stamps, as long as the object lives. Thread: one at a time, not the frame's: it allocates and writes.
// Failure: io::Failure. 1: no journal, of another pack, damaged, or open in another program; 3: the disk fails or is
// full. A change that could not be written has not happened, in the file or in the object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fjell/edit.h"
#include "fjell/export.h"
#include "fjell/pack.h"

FJELL_API_BEGIN
namespace fjell::io {

// A stamp with what it points to.
struct KeptStamp {
    KeptStamp() = default;
    explicit KeptStamp(const Stamp& stamp); // copies what it points to; it must be one that push_stamp() takes
    Stamp plain;                            // without its pointers
    std::vector<StampPoint> points;
    std::vector<float> heights_m;
    std::vector<std::uint8_t> mask;
    // Points into this object.
    [[nodiscard]] Stamp stamp() const;
};

struct JournalStamp {
    std::uint64_t id = 0; // of the journal; not used again while it is open
    KeptStamp what;
};

struct JournalLayer {
    std::uint32_t id = 0; // of the journal
    std::string name;     // at most max_layer_name bytes
    bool on = true;
    float strength = 1; // 0 to 1: its stamps' strengths are multiplied by it
    std::vector<JournalStamp> stamps;
};
inline constexpr std::size_t max_journal_layers = 1000, max_layer_name = 200;

enum class JournalAccess : std::uint8_t {
    read,  // an existing file; another program may be writing it
    extend // alone; a new file if there is none
};

// Where a pack's journal lies: PACK.journal.
[[nodiscard]] std::string journal_path(const std::string& pack);
// By its first bytes. False for what cannot be read.
[[nodiscard]] bool is_journal(const std::string& path);

class Journal {
public:
    Journal(const std::string& path, const PackHeader& pack, JournalAccess access = JournalAccess::extend);
    // Whatever pack it belongs to, to be read: pack_hash() names it.
    explicit Journal(const std::string& path);
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    [[nodiscard]] std::span<const JournalLayer> layers() const { return layers_; } // from the bottom to the top
    // Of the layers that are on, in the order in which they apply, with the layers' strengths in their own.
    // most_layers: of so many from the bottom.
    [[nodiscard]] std::vector<KeptStamp> stamps(std::size_t most_layers = max_journal_layers) const;

    // On top of the others. Returns its id.
    std::uint32_t add_layer(const std::string& name);
    // Name, on and strength become those of `layer`, whose id says which; place: from the bottom, 0 to layers() - 1.
    // Its stamps stay.
    void set_layer(const JournalLayer& layer, std::size_t place);
    void remove_layer(std::uint32_t id); // with its stamps
    // On top of the layer's others. Returns the id of the first; the others' follow. One record: all of them or none.
    std::uint64_t add_stamps(std::uint32_t layer, std::span<const KeptStamp> stamps);
    std::uint64_t add_stamp(std::uint32_t layer, const KeptStamp& stamp) { return add_stamps(layer, {&stamp, 1}); }
    // All of them or, if one is not there, none: they have gone with one record.
    void remove_stamps(std::span<const std::uint64_t> ids);
    // What was changed is on the disk when it returns.
    void commit();
    // Leaves out what no longer counts, and commits. The file is replaced whole.
    void compact();

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] std::uint64_t pack_hash() const { return head_.pack_hash; } // PackHeader::directory_hash
    [[nodiscard]] std::uint64_t file_bytes() const { return bytes_; }
    [[nodiscard]] std::uint64_t dead_bytes() const; // that compact() would leave out, about
    // Of an incomplete record at the end that was left out when it was opened: what a program that was killed wrote.
    [[nodiscard]] std::uint64_t dropped_bytes() const { return dropped_; }

private:
    friend void rebase_journal(const std::string& from, const PackHeader& pack, const std::string& to);
    struct Head { // the file's first bytes
        char magic[8];
        std::uint32_t version, head_bytes;
        std::uint64_t pack_hash;
        std::uint32_t columns, rows;
        double spacing_m[2], crs_origin[2], crs_step[2];
        std::uint64_t reserved[3];
        std::uint64_t hash; // XXH3 of all before
    };
    static Head head_for(const PackHeader& pack);
    void open_alone();
    void read(int fd);
    void read_records(std::span<const std::byte> file);
    void refuse_other_pack(const PackHeader& pack) const;
    void record(std::uint32_t kind, std::vector<std::byte> payload);
    void apply(std::uint32_t kind, std::span<const std::byte> payload);
    [[nodiscard]] std::vector<std::byte> whole_file() const;
    [[nodiscard]] JournalLayer* find_layer(std::uint32_t id);
    [[nodiscard]] JournalLayer& layer_of(std::uint32_t id);

    std::string path_;
    int fd_ = -1;         // open to extend it
    bool broken_ = false; // what the file's end holds is not known
    Head head_{};
    std::vector<JournalLayer> layers_;
    std::uint32_t next_layer_ = 1;
    std::uint64_t next_stamp_ = 1, sequence_ = 0, bytes_ = 0, dropped_ = 0;
};

// The same layers over another pack of the same ground: places are shifted by where the packs' first samples lie in
// their CRS. to: a new journal, replaced whole if it is there. Fails (1) where the packs' spacings differ, or where
// they do not lie a whole number of samples apart.
void rebase_journal(const std::string& from, const PackHeader& pack, const std::string& to);

} // namespace fjell::io
FJELL_API_END
