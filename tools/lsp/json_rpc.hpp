// JSON-RPC as the server needs it: errors, and readers of parameters that check every message.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>

#include "tools/lsp/document_text.hpp"

namespace bip::lsp {

using Json = nlohmann::json;

enum class ErrorCode : int {
  ParseError = -32700,
  InvalidRequest = -32600,
  MethodNotFound = -32601,
  InvalidParams = -32602,
  InternalError = -32603,
  NotInitialized = -32002,
  RequestFailed = -32803
};
struct RpcError {
  ErrorCode code;
  std::string message;
};
/// A result that is text already: one of megabytes takes a tenth of the time that its tree of values would.
struct JsonText {
  std::string text;
};
/// What a request is answered with.
using Reply = std::variant<Json, JsonText, RpcError>;

inline RpcError bad_params(std::string message) { return {ErrorCode::InvalidParams, std::move(message)}; }

/// The member of an object, or null (the pointer) if it is not there.
[[nodiscard]] inline const Json* member(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}
[[nodiscard]] inline const std::string* string_member(const Json& object, const char* key) {
  const Json* found = member(object, key);
  return found != nullptr && found->is_string() ? found->get_ptr<const std::string*>() : nullptr;
}
/// An integer of 0 to 2^31 - 1, the protocol's `uinteger`.
[[nodiscard]] std::optional<std::uint32_t> uint_member(const Json& object, const char* key);
/// {line, character}
[[nodiscard]] std::optional<Position> position_of(const Json* value);
[[nodiscard]] Json json_of(Position at);
/// An integer that fits, of either sign (a document's version).
[[nodiscard]] std::optional<std::int64_t> int_member(const Json& object, const char* key);

}  // namespace bip::lsp
