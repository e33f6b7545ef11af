// Journals: any records with right checksums, in a file of their own. They are refused in a Failure, or the journal is
// one that says the same when it is compacted. Seeds are records as they are stored: kind, sequence and checksum are
// put in here, or nothing behind the checksum would ever be reached.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <xxhash.h>

#include "fjell/io/failure.h"
#include "fjell/io/journal.h"
#include "input.h"
#include "io/file.h"
#include "io/stamps.h"
#include "support/temporary_folder.h"

namespace {

using namespace fjell;
using fuzz::must;

std::string told(const io::Journal& journal) {
    std::string text;
    for (const io::JournalLayer& layer : journal.layers()) {
        text += std::to_string(layer.id) + layer.name + std::to_string(layer.on) + std::to_string(layer.strength);
        for (const io::JournalStamp& stamp : layer.stamps) text += io::write_stamps({{0, stamp.what}});
    }
    return text;
}

template <typename T>
void put(std::vector<std::byte>& to, const T& value) {
    const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
    to.insert(to.end(), bytes, bytes + sizeof value);
}

// Records of a byte for the kind, two for the length, and the payload.
void append_records(std::vector<std::byte>& file, const std::uint8_t* data, std::size_t size) {
    std::uint64_t sequence = 0;
    while (size > 3) {
        const std::size_t length = std::min<std::size_t>(data[1] | std::size_t{data[2]} << 8, size - 3);
        std::vector<std::byte> head;
        for (const char c : {'F', 'J', 'r', '1'}) put(head, c);
        put(head, std::uint32_t{data[0]}), put(head, sequence++), put(head, std::uint64_t{length});
        put(head,
            static_cast<std::uint64_t>(XXH3_64bits_withSeed(data + 3, length, XXH3_64bits(head.data(), head.size()))));
        file.insert(file.end(), head.begin(), head.end());
        const auto* const payload = reinterpret_cast<const std::byte*>(data + 3);
        file.insert(file.end(), payload, payload + length);
        file.resize((file.size() + 7) / 8 * 8);
        data += 3 + length, size -= 3 + length;
    }
}

} // namespace

extern "C" int fuzz_journal(const std::uint8_t* data, std::size_t size) {
    static const test::TemporaryFolder folder;
    static const std::string path = folder / "journal";
    PackHeader pack{};
    pack.directory_hash = 1;
    std::filesystem::remove(path);
    { const io::Journal fresh(path, pack); }
    std::vector<std::byte> file = io::read_file(path);
    append_records(file, data, size);
    io::AtomicFile whole(path);
    whole.write(file);
    whole.commit();
    try {
        io::Journal journal(path, pack);
        const std::string before = told(journal);
        (void)journal.stamps();
        must(journal.dropped_bytes() <= file.size(), "what is dropped was there");
        journal.compact();
        must(told(journal) == before && told(io::Journal(path)) == before, "a compacted journal says the same");
    } catch (const io::Failure& failure) {
        must(failure.exit_code == 1, "what cannot be a journal is the input's fault");
    }
    return 0;
}
