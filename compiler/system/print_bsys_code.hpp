// Pieces of .bsys text: names, references, places, literals, expressions and statements. Internal to system/.
#pragma once
#include <string>
#include <string_view>

#include "compiler/system/bsys_text.hpp"

namespace bip::system::text {

void put_quoted(std::string& out, std::string_view text);
/// Bare if it can be, else quoted.
void put_name(std::string& out, std::string_view name);
/// Decimal digits, without reading a format: a text of .bsys is numbers for the greater part.
void put_number(std::string& out, std::uint64_t number);
/// A row number, followed by `:name` for the reader's eye if the name is bare.
void put_ref(std::string& out, std::uint32_t row, std::string_view name);
/// " @file:line:column", or nothing if there is no place.
void put_loc(std::string& out, const Loc& loc);
void put_literal(std::string& out, const Value& value, const CodeTable& code);
void put_expr(std::string& out, const CodeTable& code, ExprId expr, const CodeScope& scope);
/// All statements of a body, a blank before each.
void put_stmts(std::string& out, const CodeTable& code, StmtId first, const CodeScope& scope);
/// Bounds on clocks, and `resume`.
void put_when(std::string& out, const CodeTable& code, const AtomType& type, const TimeGuard& when,
              const CodeScope& scope);
void put_resume(std::string& out, const CodeTable& code, const AtomType& type, const Resume& resume,
                const CodeScope& scope);

}  // namespace bip::system::text
