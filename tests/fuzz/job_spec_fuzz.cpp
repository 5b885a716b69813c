// job-spec-fuzz: bytes of job specifications, see fuzz_job_spec.h and fuzz_main.h.
#include "tests/fuzz/fuzz_job_spec.h"
#include "tests/fuzz/fuzz_main.h"

int main(int argc, char** argv) {
  return shutterline::FuzzMain(argc, argv, "job-spec-fuzz", shutterline::FuzzJobSpec,
                               shutterline::CheckJobSpecBytes);
}
