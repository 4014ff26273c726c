// SPDX-License-Identifier: MIT
#pragma once
/// Script of `palpate falcon`: faults over time and motion of the hand (docs/falcon.md).

#include <filesystem>
#include <string>
#include <vector>

#include "device/falcon/body.hpp"
#include "device/falcon/emulator.hpp"
#include "device/falcon/link_faults.hpp"

namespace palpate::cli {

struct FalconScript {
  device::falcon::FirmwareOptions firmware{};
  device::falcon::FaultScript faults{};
  device::falcon::GripScript grip{};
  bool sets_firmware = false;  ///< true if the script has a [firmware] table
  bool moves_grip = false;     ///< true if the script has a [grip] table
};

/// Reads and checks a script. An empty path gives an empty script. Throws InputError with one line
/// per problem, with file and line.
FalconScript read_falcon_script(const std::filesystem::path& path,
                                const std::vector<std::string>& overrides);

}  // namespace palpate::cli
