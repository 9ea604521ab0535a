// One value for each parameter of a request, for the rule that judges it and for the codels that get it.
//
// Parameters that rules declare stand in the request's parentheses; codels get an input as well, and those of genom3
// have their parameters from there, by name. This settles both when a request is accepted.
#pragma once
#include <string>

#include "bip/service_requests.hpp"

namespace bip::serve {

/// Of the model's C++, if its codels have parameters by name: what is wrong with an input; empty if nothing is.
using InputProblem = const char* (*)(const char* service, const char* input);

/// Writes the request `text` and its `input` so that they have the same values: a value of the input alone goes into
/// the parentheses, and one of the parentheses into the input, if codels have it by name (`input_problem` is not null).
/// Returns an empty text; or why the request is refused: two values of a parameter differ, or an input has values
/// without names.
[[nodiscard]] std::string settle_values(const ServiceText& service, InputProblem input_problem, std::string& text,
                                        std::string& input);

}  // namespace bip::serve
