// Everything a flight writes, opened or checked before the first frame: nobody flies for an hour to learn that a folder
// is missing.
#pragma once

#include <memory>
#include <string>

#include "flight/session.h"
#include "fly/options.h"
#include "io/file.h"

namespace fjell::flight {

class Outputs {
public:
    // Throws Failure: 1 a folder is missing, 3 it cannot be written.
    explicit Outputs(const FlightOptions& options);

    // Writes CSV and JSON and prints the summary, unless standard output is one of them.
    void finish(const FlightOptions& options, const Session& session, const CameraPath& path, const FlightLog& log,
                const Verification& verification);

private:
    std::unique_ptr<io::AtomicFile> csv_, json_, record_;
};

} // namespace fjell::flight
