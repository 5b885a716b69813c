#include "tests/fuzz/fuzz_job_spec.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include <random>

#include "common/job/job_spec.h"
#include "proto/convert/bounded_parse.h"
#include "proto/convert/job_spec.h"
#include "tests/fuzz/message_mutator.h"

namespace shutterline {
namespace {

constexpr size_t kMaxFields = 10'000;

/// Some of each: the seed chooses.
JobSpec ValidSpec(std::mt19937_64& random) {
  JobSpec spec;
  spec.name = "job";
  spec.scene.root_name = "fox.glb";
  spec.scene.files.push_back({"fox.glb", Sha256("fox"), 3});
  if (random() % 2 == 0) spec.scene.files.push_back({"textures/fur.png", Sha256("fur"), 3});
  spec.frames = {int(random() % 3), 3 + int(random() % 3), 1};
  spec.render.width = 64;
  spec.render.height = 48;
  if (random() % 2 == 0) spec.render.occlusion.emplace();
  if (random() % 2 == 0) spec.render.shutter_curve = {{0.0, 0.0}, {0.5, 1.0}, {1.0, 0.0}};
  spec.render.filter = FilterKind(random() % 4);
  if (random() % 2 == 0) spec.render.filter_radius = 0.5 + double(random() % 8) / 2.5;
  return spec;
}

}  // namespace

std::string CheckJobSpecBytes(const std::string& bytes) {
  v1::JobSpec message;
  if (const absl::Status parsed = convert::ParseBounded(bytes, kMaxFields, message); !parsed.ok()) {
    return absl::IsInvalidArgument(parsed) ? "" : absl::StrCat("parse: ", parsed.ToString());
  }
  const absl::StatusOr<JobSpec> spec = convert::FromProto(message);
  if (!spec.ok()) {
    if (!absl::IsInvalidArgument(spec.status())) return absl::StrCat("refused as ", spec.status().ToString());
    return spec.status().message().empty() ? "refused without a reason" : "";
  }
  if (const absl::Status valid = Validate(*spec); !valid.ok()) {
    return absl::StrCat("taken, but not valid: ", valid.ToString());
  }
  const v1::JobSpec back = convert::ToProto(*spec);
  const absl::StatusOr<JobSpec> again = convert::FromProto(back);
  if (!again.ok()) return absl::StrCat("taken, but not again: ", again.status().ToString());
  if (!(*again == *spec)) return "other after a way through the message";
  std::string first, second;
  back.SerializeToString(&first);
  convert::ToProto(*again).SerializeToString(&second);
  if (first != second) return "its message is another the second time";
  if (PictureKey(spec->scene, spec->render) != PictureKey(again->scene, again->render))
    return "another picture key";
  return "";
}

std::string FuzzJobSpec(uint64_t seed) {
  std::mt19937_64 random(seed);
  v1::JobSpec message = convert::ToProto(ValidSpec(random));
  if (random() % 8 != 0) MutateFields(message, random);
  std::string bytes = message.SerializeAsString();
  if (random() % 3 == 0) MutateBytes(bytes, random);
  const std::string broken = CheckJobSpecBytes(bytes);
  return broken.empty() ? "" : absl::StrCat("job spec: ", broken, "; bytes ", absl::BytesToHexString(bytes));
}

}  // namespace shutterline
