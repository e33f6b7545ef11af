// Everything a flight writes, opened or checked before the first frame: nobody flies for an hour to learn that a folder
// is missing.
#pragma once

#include <memory>
#include <string>

#include "fly/options.h"
#include "io/file.h"
#include "session/session.h"

namespace fjell::session {

class Outputs {
public:
    // Makes the folder of --render where there is none. Throws Failure: 1 a folder is missing, 3 it cannot be written.
    explicit Outputs(const FlightOptions& options);
    ~Outputs(); // a folder that it has made, and that nothing was written to, goes
    Outputs(const Outputs&) = delete;
    Outputs& operator=(const Outputs&) = delete;

    // Writes CSV and JSON and prints the summary, unless standard output is one of them.
    void finish(const FlightOptions& options, const Session& session, const CameraPath& path, const FlightLog& log,
                const Verification& verification);

    // Of a flight that ends early: the CSV of the frames until then. Returns what to say of it; nothing of none.
    std::string keep_measured(const FlightOptions& options, const FlightLog& log);

private:
    std::unique_ptr<io::AtomicFile> csv_, json_, record_;
    std::string made_folder_;
};

} // namespace fjell::session
