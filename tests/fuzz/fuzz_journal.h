#pragma once

#include <cstdint>
#include <string>

namespace shutterline::server {

/// Writes journal segments that are whole, damaged or nonsense, as `seed` says, into `folder`, which is
/// empty, and opens them. What is wrong with the outcome; empty: nothing. Held to: every tile that is found
/// stands in a file in a record whose checksum holds, by another implementation of it; every record before
/// the first damage of its file is found; and the journal goes on from there.
std::string FuzzJournal(uint64_t seed, const std::string& folder);

}  // namespace shutterline::server
