// GDAL, loaded when the first file asks for it: with it come a hundred libraries, 60 to 100 ms of every start.
//
// gdal_names.inc has what the baker's objects call, FUNCTION(name), and what they refer to, TYPEINFO(name); the build
// asks nm for it. A function is one jump through a table (late_gdal.S). A typeinfo, of a class of GDAL's that ours
// derive from, is a copy, as the linker would have made one.
#include "baker/read/gdal_file.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include <dlfcn.h>

#include <fmt/format.h>

extern "C" {
extern char fjell_gdal_table[];
// Whoever calls GDAL before load_gdal() ends here.
[[noreturn]] void fjell_gdal_missing() {
    std::fputs("GDAL was called before load_gdal()\n", stderr);
    std::abort();
}
}

namespace fjell::baker {

namespace {
void* gdal = nullptr;
}

void load_gdal() {
    static std::once_flag once;
    std::call_once(once, [] {
        gdal = dlopen(FJELL_GDAL, RTLD_LAZY);
        const auto find = [](const char* name) {
            if (void* const found = gdal ? dlsym(gdal, name) : nullptr) return found;
            const char* const why = dlerror();
            throw Failure(3, fmt::format("GDAL cannot be loaded ({}); install " FJELL_GDAL, why ? why : "not found"));
        };
        char* to = fjell_gdal_table;
        void* found = nullptr;
#define FUNCTION(name) found = find(#name), std::memcpy(to, &found, 8), to += 8;
#define TYPEINFO(name) std::memcpy(to, find(#name), 24), to += 24;
#include "gdal_names.inc"
#undef FUNCTION
#undef TYPEINFO
    });
}

void hush_hdf5() {
    using SetAuto = int (*)(std::int64_t stack, void* function, void* data);
    static const auto set_auto = reinterpret_cast<SetAuto>(dlsym(gdal, "H5Eset_auto2")); // GDAL may be without
    if (set_auto) (void)set_auto(0, nullptr, nullptr);
}

} // namespace fjell::baker
