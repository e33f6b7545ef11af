// Which files a raster consists of: so that no output replaces one of them, and none that would block is opened.
#pragma once

#include <string>
#include <vector>

namespace fjell::baker {

// path: a file, or one of GDAL's names for what is in one. The files themselves, and of a VRT those that it names, as
// do VRTs among these. Throws Failure (1) for a pipe, a device or a socket among them, whose opening might never end.
// Opens nothing but VRTs.
[[nodiscard]] std::vector<std::string> raster_sources(const std::string& path);

// These, and what GDAL reads beside them (.aux.xml, .prj, .hdr, .tfw, .ovr, ...), as far as it is there. what: as for
// open_raster(), whose Failures it throws.
[[nodiscard]] std::vector<std::string> raster_files(const std::string& path, const char* what);

} // namespace fjell::baker
