#include "client/parse_outputs.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <set>
#include <string>

#include "client/parse.h"
#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

template <typename Enum, typename Parse>
absl::StatusOr<std::vector<Enum>> ParseSet(absl::string_view text, const Parse& parse,
                                           absl::string_view allowed) {
  std::vector<Enum> set;
  for (const absl::string_view word : absl::StrSplit(text, ',')) {
    const std::optional<Enum> value = parse(word);
    if (!value) return absl::InvalidArgumentError(absl::StrCat("must be some of ", allowed, ", with commas"));
    if (std::find(set.begin(), set.end(), *value) != set.end()) {
      return absl::InvalidArgumentError(absl::StrCat("names '", word, "' twice"));
    }
    set.push_back(*value);
  }
  std::sort(set.begin(), set.end());
  return set;
}

absl::Status SetOcclusion(absl::string_view key, absl::string_view value, OcclusionSettings& settings) {
  if (key == "lines") {
    SL_ASSIGN_OR_RETURN(const int64_t lines, ParseWhole(value, 1, kMaxOcclusionLines));
    settings.lines = int(lines);
  } else if (key == "radius") {
    SL_ASSIGN_OR_RETURN(settings.radius, ParseReal(value, kMinOcclusionRadius, kMaxOcclusionRadius,
                                                   "a number of metres above 0"));
  } else if (key == "falloff") {
    const auto falloff = ParseOcclusionFalloff(value);
    if (!falloff) return absl::InvalidArgumentError("must be none, linear or quadratic");
    settings.falloff = *falloff;
  } else if (key == "pattern") {
    const auto pattern = ParseOcclusionPattern(value);
    if (!pattern) return absl::InvalidArgumentError("must be pole or tilted");
    settings.pattern = *pattern;
  } else if (key == "motion") {
    if (value != "on" && value != "off") return absl::InvalidArgumentError("must be on or off");
    settings.motion = value == "on";
  } else {
    return absl::InvalidArgumentError("is not known: lines, radius, falloff, pattern and motion are");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<Aov>> ParseAovs(absl::string_view text) {
  return ParseSet<Aov>(text, ParseAov,
                       "depth, position, normal, motion, albedo, ao, samples, object-id and material-id");
}

absl::StatusOr<std::vector<Matte>> ParseMattes(absl::string_view text) {
  return ParseSet<Matte>(text, ParseMatte, "object and material");
}

absl::StatusOr<OcclusionSettings> ParseOcclusion(absl::string_view text) {
  OcclusionSettings settings;
  if (text == "on") return settings;
  std::set<absl::string_view> seen;
  for (const absl::string_view pair : absl::StrSplit(text, ',')) {
    const size_t equals = pair.find('=');
    if (equals == absl::string_view::npos) {
      return absl::InvalidArgumentError(
          "must be on, or KEY=VALUE,... as in lines=16,radius=2,falloff=linear");
    }
    const absl::string_view key = pair.substr(0, equals);
    if (!seen.insert(key).second) return absl::InvalidArgumentError(absl::StrCat(key, ": is given twice"));
    SL_RETURN_IF_ERROR(Annotate(SetOcclusion(key, pair.substr(equals + 1), settings), key));
  }
  return settings;
}

}  // namespace shutterline::client
