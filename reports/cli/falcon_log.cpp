// SPDX-License-Identifier: MIT
#include "reports/cli/falcon_log.hpp"

#include <cerrno>
#include <cstring>

#include "fixtures/io/file_bytes.hpp"
#include "model/dynamics/scene_check.hpp"

namespace palpate::cli {
namespace {

using namespace device::falcon;

constexpr std::size_t most_rows = 1U << 16U;  // a minute at 1 kHz
constexpr std::size_t many_rows = 256;
constexpr unsigned button_bits = 0x0F;
constexpr unsigned homed_shift = 4;

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw InputError(path.string() + ": cannot be written: " + std::strerror(errno));
}

}  // namespace

FalconLog::FalconLog(const std::filesystem::path& path, const Firmware& firmware)
    : path_(path),
      temporary_(io::temporary_name(path)),
      file_(std::fopen(temporary_.c_str(), "we"), &std::fclose),
      firmware_(firmware) {
  if (!file_) { fail(path_); }
  rows_.reserve(most_rows);
  std::fputs(
      "time_s,word_1,word_2,word_3,homing,leds,count_1,count_2,count_3,buttons,homed,event,state\n",
      file_.get());
}

FalconLog::~FalconLog() {
  if (file_) { std::remove(temporary_.c_str()); }
}

void FalconLog::served(double time_s, const HostPacket& request,
                       const DevicePacket& reply) noexcept {
  add({.time = time_s, .state = firmware_.state(), .request = request, .reply = reply});
}

void FalconLog::happened(double time_s, FirmwareEvent event) noexcept {
  add({.time = time_s, .event = event, .state = firmware_.state()});
}

void FalconLog::add(const Row& row) noexcept {
  if (rows_.size() < most_rows) {
    rows_.push_back(row);
  } else {
    ++left_out_;
  }
}

void FalconLog::flush_if_many() noexcept {
  if (rows_.size() >= many_rows) { flush(); }
}

void FalconLog::flush() noexcept {
  for (const Row& row : rows_) { write(row); }
  rows_.clear();
}

void FalconLog::write(const Row& row) noexcept {
  std::FILE* file = file_.get();
  if (row.event) {
    failed_ |= std::fprintf(file, "%.6f,,,,,,,,,,,%s,%s\n", row.time, name_of(*row.event),
                            name_of(row.state)) < 0;
    return;
  }
  const unsigned asked = info_bits(row.request);
  const unsigned told = info_bits(row.reply);
  failed_ |=
      std::fprintf(file, "%.6f,%d,%d,%d,%u,%u,%d,%d,%d,%u,%u,request,%s\n", row.time,
                   row.request.words[0], row.request.words[1], row.request.words[2], asked & 1U,
                   asked >> 1U, row.reply.counts[0], row.reply.counts[1], row.reply.counts[2],
                   told & button_bits, told >> homed_shift, name_of(row.state)) < 0;
}

void FalconLog::finish() {
  flush();
  failed_ |= std::fclose(file_.release()) != 0;
  const bool renamed = !failed_ && std::rename(temporary_.c_str(), path_.c_str()) == 0;
  if (renamed) { return; }
  std::remove(temporary_.c_str());
  fail(path_);
}

}  // namespace palpate::cli
