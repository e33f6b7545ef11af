// Everything a flight writes, opened or checked before the first frame: nobody flies for an hour to learn that a folder
// is missing.
#pragma once

#include <memory>
#include <string>

#include "fly/options.h"
#include "fly/session.h"
#include "host/file.h"

namespace fjell::fly {

class Outputs {
public:
    // Throws Failure: 1 a folder is missing, 3 it cannot be written.
    explicit Outputs(const Options& options);

    // Writes CSV and JSON and prints the summary, unless standard output is one of them.
    void finish(const Options& options, const Session& session, const CameraPath& path, const FlightLog& log,
                const Verification& verification);

private:
    std::unique_ptr<host::AtomicFile> csv_, json_, record_;
};

} // namespace fjell::fly
