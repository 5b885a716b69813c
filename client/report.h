#pragma once

#include "client/command_line.h"
#include "client/delivery.h"
#include "client/upload.h"

namespace shutterline::client {

/// Prints what a job delivered (as JSON, or a line per file) and, where the job did not succeed, an error
/// line; returns the process's exit code.
ExitCode Report(Console& console, const Delivery& delivery, const UploadReport& upload, bool json,
                bool quiet);

}  // namespace shutterline::client
