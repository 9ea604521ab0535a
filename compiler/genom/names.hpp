// Maps names of a description to names of BIP: a reserved word gets an underscore, the second owner of a name a suffix.
#pragma once
#include <set>
#include <string>
#include <string_view>

namespace bip::genom {

/// `name`, or `name_` if BIP reserves it; bytes that no BIP name has become underscores.
[[nodiscard]] std::string bip_name(std::string_view name);
/// "laser-rf" -> "LaserRf": the beginning of type names of a module.
[[nodiscard]] std::string type_name(std::string_view name);
/// The function that BIP calls for a codel, with its owner's number: it contains the codel's exceptions.
[[nodiscard]] std::string codel_function(std::string_view codel);
[[nodiscard]] std::string upper(std::string_view name);

/// Names of one scope.
class Scope {
 public:
  /// `name`, else `name_kind`, else that with a number.
  std::string claim(const std::string& name, const std::string& kind);

 private:
  std::set<std::string> taken_;
};

}  // namespace bip::genom
