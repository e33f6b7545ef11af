// Runs a fuzz target. With libFuzzer, as `./dev test --long` has it, it explores: fuzz TARGET OPTION... FOLDER...
//
// Without, as `./dev test` has it: every seed as it is, then ROUNDS mutations of the seeds in turn, always the same
// ones. fuzz TARGET ROUNDS SEED... where SEED is a file, or a folder of them. What breaks is written to ./broken-input;
// it can be given to `fuzz TARGET 0 broken-input`.
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

// Each target's function.
#define FUZZ_TARGETS(X)                                                                                                \
    X(fuzz_checkpoint)                                                                                                 \
    X(fuzz_journal)                                                                                                    \
    X(fuzz_materials)                                                                                                  \
    X(fuzz_netcdf)                                                                                                     \
    X(fuzz_pack)                                                                                                       \
    X(fuzz_page)                                                                                                       \
    X(fuzz_path) X(fuzz_profile) X(fuzz_ramp) X(fuzz_recipe) X(fuzz_record) X(fuzz_set) X(fuzz_stamps) X(fuzz_terrain)
#define DECLARE(name) int name(const std::uint8_t* data, std::size_t size);
extern "C" {
FUZZ_TARGETS(DECLARE)
}

namespace {

using Target = int (*)(const std::uint8_t* data, std::size_t size);

Target target_of(std::string_view name) { // null: there is none
#define RETURN_IF(target)                                                                                              \
    if (name == #target) return target;
    FUZZ_TARGETS(RETURN_IF)
    return nullptr;
}

} // namespace

#if defined(FJELL_LIBFUZZER)

namespace {
Target explored = nullptr;
}
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) { // takes the first word away
    explored = *argc < 2 ? nullptr : target_of((*argv)[1]);
    if (explored == nullptr) std::exit((std::fprintf(stderr, "usage: %s TARGET OPTION... FOLDER...\n", (*argv)[0]), 2));
    for (int i = 2; i <= *argc; ++i) (*argv)[i - 1] = (*argv)[i]; // with the null behind them
    --*argc;
    return 0;
}
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    return explored(data, size);
}

#else

extern "C" void __sanitizer_set_death_callback(void (*callback)()) __attribute__((weak));

namespace {

using Bytes = std::vector<std::uint8_t>;
const Bytes* current = nullptr;

void keep_current() {
    if (!current) return;
    std::FILE* const file = std::fopen("broken-input", "wb");
    if (!file) return;
    (void)std::fwrite(current->data(), 1, current->size(), file);
    (void)std::fclose(file);
}

void keep_current_on_failure() {
    if (__sanitizer_set_death_callback) __sanitizer_set_death_callback(keep_current);
    const auto on_signal = [](int number) {
        keep_current();
        (void)std::signal(number, SIG_DFL);
        (void)std::raise(number);
    };
    (void)std::signal(SIGABRT, on_signal);
    if (!__sanitizer_set_death_callback) (void)std::signal(SIGSEGV, on_signal);
}

void run(Target target, const Bytes& bytes) {
    current = &bytes;
    (void)target(bytes.data(), bytes.size());
    current = nullptr;
}

void mutate(Bytes& bytes, std::mt19937& random) {
    const auto below = [&](std::size_t count) {
        return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
    };
    for (std::size_t count = 1 + below(6); count > 0 && !bytes.empty(); --count) {
        // The headers and the directory are small beside the rest, and worth more.
        const std::size_t few = std::min<std::size_t>(bytes.size(), 512), where = below(10);
        const std::size_t at = where < 6 ? below(bytes.size()) : where < 9 ? below(few) : bytes.size() - 1 - below(few);
        switch (below(12)) {
        case 0: bytes.resize(at); break;
        case 1:
            bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(below(256)));
            break;
        case 2: bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at)); break;
        case 3:
        case 4: bytes[at] = below(2) ? 0xff : 0; break;
        case 5:
        case 6: bytes[at] = static_cast<std::uint8_t>(bytes[at] + (below(2) ? 1 : 255)); break;
        case 7:
        case 8: bytes[at] = static_cast<std::uint8_t>(below(256)); break;
        default: bytes[at] ^= static_cast<std::uint8_t>(1u << below(8)); break;
        }
    }
}

std::vector<std::filesystem::path> files_of(const std::filesystem::path& seed) {
    if (!std::filesystem::is_directory(seed)) return {seed};
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(seed)) files.push_back(entry.path());
    std::sort(files.begin(), files.end()); // the same on every machine
    return files;
}

} // namespace

int main(int argc, char** argv) {
    const Target target = argc < 4 ? nullptr : target_of(argv[1]);
    if (target == nullptr) return std::fprintf(stderr, "usage: %s TARGET ROUNDS SEED_FILE_OR_FOLDER...\n", argv[0]), 2;
    keep_current_on_failure();
    std::vector<Bytes> seeds;
    for (int i = 3; i < argc; ++i)
        for (const auto& path : files_of(argv[i])) {
            std::ifstream file(path, std::ios::binary);
            seeds.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
            if (seeds.back().empty()) return std::fprintf(stderr, "%s: no such seed, or empty\n", path.c_str()), 2;
            run(target, seeds.back());
        }
    if (seeds.empty()) return std::fprintf(stderr, "%s: no seeds\n", argv[1]), 2;
    std::mt19937 random(1);
    const long rounds = std::strtol(argv[2], nullptr, 10);
    for (long round = 0; round < rounds; ++round) {
        Bytes bytes = seeds[static_cast<std::size_t>(round) % seeds.size()];
        mutate(bytes, random);
        run(target, bytes);
    }
    std::printf("%zu seeds, %ld mutations: nothing broke\n", seeds.size(), rounds);
    return 0;
}

#endif
