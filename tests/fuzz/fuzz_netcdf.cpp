// Headers of netCDF files: whatever they claim, their length is told soon and without asking for memory.
#include <cstdint>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

#include "baker/read/netcdf_length.h"
#include "input.h"

using namespace fjell;
using fuzz::must;

extern "C" int fuzz_netcdf(const std::uint8_t* data, std::size_t size) {
    const int fd = memfd_create("fuzz", MFD_CLOEXEC);
    must(fd >= 0 && write(fd, data, size) == static_cast<ssize_t>(size), "there is memory");
    const std::string path = "/proc/self/fd/" + std::to_string(fd);
    const auto length = baker::netcdf_length(path);
    must(baker::netcdf_length(path) == length, "a length follows from the bytes alone");
    const bool classic = size >= 4 && data[0] == 'C' && data[1] == 'D' && data[2] == 'F' &&
                         (data[3] == 1 || data[3] == 2 || data[3] == 5);
    must(length.has_value() == classic, "the magic number tells what has a length");
    close(fd);
    return 0;
}
