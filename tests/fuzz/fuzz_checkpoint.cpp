// Checkpoints of interrupted bakes: bytes that are not one begin anew; what is one is written again as it was. The
// first byte tells whether a mutation's identity and hash are repaired, which it would never guess.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include <unistd.h>
#include <xxhash.h>

#include "baker/bake/checkpoint.h"
#include "input.h"

namespace {

using namespace fjell;
using baker::Checkpoint;
using fuzz::must;

struct Folder {
    std::string path = "/tmp/fjell-fuzz-XXXXXX";
    Folder() { must(mkdtemp(path.data()) != nullptr, "there is a folder for temporary files"); }
    ~Folder() {
        unlink((path + "/checkpoint").c_str());
        rmdir(path.c_str());
    }
};

std::string slurp(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

constexpr std::size_t head_bytes = 24; // magic number and identity

} // namespace

extern "C" int fuzz_checkpoint(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    static const Folder folder;
    static const std::string path = folder.path + "/checkpoint", fresh = [] {
        Checkpoint(path, "fuzz").write();
        return slurp(path);
    }();
    std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    const bool repaired = data[0] & 1;
    if (repaired) {
        bytes.resize(fresh.size());
        std::memcpy(bytes.data(), fresh.data(), head_bytes);
        const std::uint64_t hash = XXH3_64bits(bytes.data(), bytes.size() - sizeof hash);
        std::memcpy(bytes.data() + bytes.size() - sizeof hash, &hash, sizeof hash);
    }
    std::ofstream(path, std::ios::binary) << bytes;
    Checkpoint checkpoint(path, "fuzz");
    must(!repaired || checkpoint.resumed(), "a whole checkpoint is taken");
    if (!checkpoint.resumed()) {
        must(checkpoint.state.complete == 0 && checkpoint.state.spool.bytes == 0, "else all is to be done");
        return 0;
    }
    must(!Checkpoint(path, "another").resumed(), "no other bake takes it");
    checkpoint.write();
    must(slurp(path) == bytes, "a checkpoint is written as it was");
    return 0;
}
