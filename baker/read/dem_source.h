// A height field in memory as a source.
#pragma once

#include "baker/read/dem.h"
#include "baker/read/source.h"

namespace fjell::baker {

// Keeps the Dem. Its voids are NaN to readers: the ground that it has under them is not handed out. Any number of
// readers at once.
class DemSource final : public HeightSource {
public:
    explicit DemSource(Dem dem);

    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override;
    [[nodiscard]] std::vector<Window> windows(std::size_t most) const override;
    // Holes where the Dem has voids; its own quantum. Throws Failure 1 when there is nothing but voids.
    [[nodiscard]] Settled settle(const Census& census) const override;
    [[nodiscard]] std::string identity() const override; // a hash of everything

private:
    Dem dem_;
};

} // namespace fjell::baker
