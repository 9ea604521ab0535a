// A System that uses every kind of row, every operator and every odd corner of .bsys. Built by hand: no front end.
#pragma once
#include "compiler/system/system.hpp"

namespace bip::test {

/// Sound by `validate`.
System make_sample_system();

}  // namespace bip::test
