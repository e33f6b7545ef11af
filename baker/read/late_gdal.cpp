// GDAL, loaded when the first file asks for it: with it come a hundred libraries, 60 to 100 ms of every start.
//
// gdal_names.h has what the baker's objects call, FUNCTION(name), and what they refer to, TYPEINFO(name); the build
// asks nm for it. A function is here one jump through a table that load_gdal() fills. A typeinfo, of a class of GDAL's
// that ours derive from, is a copy, as the linker would have made one.
#include "baker/read/gdal_file.h"

#include <cstring>
#include <mutex>

#include <dlfcn.h>

#include <fmt/format.h>

#if defined(__x86_64__)
#define JUMP "jmp *1b(%rip)\n"
#elif defined(__aarch64__)
#define JUMP "adrp x16, 1b\nldr x16, [x16, :lo12:1b]\nbr x16\n"
#else
#error "add this processor's jump, or link GDAL itself"
#endif
#define FUNCTION(name)                                                                                                 \
    ".bss\n1: .skip 8\n.text\n.globl " #name "\n.hidden " #name "\n.type " #name ", %function\n" #name ": " JUMP
#define TYPEINFO(name) ".bss\n.globl " #name "\n.hidden " #name "\n" #name ": .skip 24\n"
asm(".bss\n.balign 8\nfjell_gdal_table:\n"
#include "gdal_names.h"
    ".text\n");
#undef FUNCTION
#undef TYPEINFO

extern "C" char fjell_gdal_table[] __attribute__((visibility("hidden")));

namespace fjell::baker {

void load_gdal() {
    static std::once_flag once;
    std::call_once(once, [] {
        void* const gdal = dlopen(FJELL_GDAL, RTLD_LAZY);
        const auto find = [&](const char* name) {
            if (void* const found = gdal ? dlsym(gdal, name) : nullptr) return found;
            const char* const why = dlerror();
            throw Failure(3, fmt::format("GDAL cannot be loaded ({}); install " FJELL_GDAL, why ? why : "not found"));
        };
        char* to = fjell_gdal_table;
        void* found = nullptr;
#define FUNCTION(name) found = find(#name), std::memcpy(to, &found, 8), to += 8;
#define TYPEINFO(name) std::memcpy(to, find(#name), 24), to += 24;
#include "gdal_names.h"
#undef FUNCTION
#undef TYPEINFO
    });
}

} // namespace fjell::baker
