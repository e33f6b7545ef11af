// How long a netCDF file must be. The netCDF library hands out zeros for what a cut file lacks, so that half an ocean
// would bake as a plain at sea level without a word.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace fjell::baker {

inline constexpr std::uint64_t netcdf_damaged = ~std::uint64_t{0};

// The first byte after the last value that the header of a classic netCDF file (CDF-1, CDF-2, CDF-5) promises;
// netcdf_damaged when its header cannot be followed to its end (the netCDF library would believe its counts, and ask
// for any amount of memory); nothing when the file is of another kind. netCDF-4 files are HDF5, which notices by
// itself. O(header), reads nothing else. Never throws but std::bad_alloc.
[[nodiscard]] std::optional<std::uint64_t> netcdf_length(const std::string& path);

} // namespace fjell::baker
