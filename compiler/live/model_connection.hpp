// A connection to a running `bipc serve`, as lines of JSON (compiler/docs/serve.md): its Unix socket, or its port on
// the loopback. Small requests are written at once; what the model does not read waits here.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/base/result.hpp"

namespace bip::live {

class ModelConnection {
 public:
  /// `where` is the path of a socket, `PORT`, or `PORT:TOKEN`; `token` is that of a port without one. A port is one of
  /// this machine: the token and all that follows would pass a network in clear.
  [[nodiscard]] static Result<std::unique_ptr<ModelConnection>> open(const std::string& where,
                                                                     const std::string& token);
  /// Of a connected socket that does not block, which it closes.
  ModelConnection(int descriptor, std::string token) : descriptor_(descriptor), token_(std::move(token)) {}
  ~ModelConnection();
  ModelConnection(const ModelConnection&) = delete;
  ModelConnection& operator=(const ModelConnection&) = delete;

  /// Of a port; empty for a Unix socket.
  [[nodiscard]] const std::string& token() const { return token_; }
  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// Sends a line. False: the other end is gone, or has read nothing for more than kMostWaiting bytes.
  [[nodiscard]] bool send(const std::string& line);
  /// Writes what waits.
  [[nodiscard]] bool flush();
  /// Appends the lines that have come, without waiting. False: the other end is gone.
  [[nodiscard]] bool receive(std::vector<std::string>& lines);
  /// Waits for a line; nothing after `seconds`, or if the other end is gone.
  [[nodiscard]] std::optional<std::string> wait_for_line(int seconds);

  static constexpr std::size_t kMostWaiting = std::size_t{1} << 20, kMostReceived = std::size_t{64} << 20;

 private:
  int descriptor_;
  std::string token_, received_, waiting_;
  std::vector<std::string> early_;  // lines that came behind the one that was waited for
};

}  // namespace bip::live
