// SPDX-License-Identifier: MIT
#pragma once
/// log.csv of `palpate falcon`: one row per request and per event (docs/formats.md).

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "device/falcon/emulator.hpp"

namespace palpate::cli {

/// Rows wait in memory, reserved beforehand, until flush(): nothing is written between a request
/// and its reply. The file has a temporary name until finish().
class FalconLog final : public device::falcon::EmulatorObserver {
 public:
  /// Throws InputError when nothing can be written there.
  FalconLog(const std::filesystem::path& path, const device::falcon::Firmware& firmware);
  FalconLog(const FalconLog&) = delete;
  FalconLog& operator=(const FalconLog&) = delete;
  ~FalconLog() override;

  void served(double time_s, const device::falcon::HostPacket& request,
              const device::falcon::DevicePacket& reply) noexcept override;
  void happened(double time_s, device::falcon::FirmwareEvent event) noexcept override;

  /// Writes the rows that wait, once there are many.
  void flush_if_many() noexcept;
  /// Writes the rest and gives the file its name. Throws InputError.
  void finish();
  [[nodiscard]] std::int64_t left_out() const noexcept { return left_out_; }

 private:
  struct Row {
    double time = 0.0;
    std::optional<device::falcon::FirmwareEvent> event{};  ///< empty: a request
    device::falcon::FirmwareState state{};
    device::falcon::HostPacket request{};
    device::falcon::DevicePacket reply{};
  };
  void add(const Row& row) noexcept;
  void write(const Row& row) noexcept;
  void flush() noexcept;

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  const device::falcon::Firmware& firmware_;
  std::vector<Row> rows_{};
  std::int64_t left_out_ = 0;
  bool failed_ = false;
};

}  // namespace palpate::cli
