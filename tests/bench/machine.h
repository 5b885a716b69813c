#pragma once

#include <string>

namespace shutterline::bench {

/// The processor's name, its cores and its vector instructions.
std::string MachineName();
/// What else the machine was doing: load averages.
std::string MachineLoad();

}  // namespace shutterline::bench
