"""Brewster's fields against colour-science, tmm and py_pol: interfaces, films, plates, elements.

Numbers come from `brewster eval`; random inputs, fixed seed.  Conventions here are exp(+iωt),
n = η − ik, and p = z × s on every side, so that r_p = −r_s at normal incidence.  The maps are

    tmm             exp(−iωt), n = η + ik: indices go there and amplitudes come back conjugated;
                    the sign of r_p is ours
    colour-science  angles in degrees, lengths in nm; r_p has the other sign.  Real indices below
                    the critical angles at any incidence, complex ones at normal incidence: 0.4.7
                    is off by up to 0.8 in R for complex ones at oblique incidence, and has no
                    number for total reflection.  tmm judges there
    py_pol          exp(+iωt), fast axis first, the sign of S3 and of ellipticities: as here; its
                    diattenuator holds the transmittance, its `depolarization_index` is √(1 − P²)

Amplitudes and powers may differ by 64 ε (1 + |value| + what each input does to it, relative to
its own size), as the other program's differences say, ε = 2^-52; fivefold where that program's
degrees and nanometres are rounded too.  Plates may add 4 ε k₀ d |M| of phase, as documented.
Elements and Mueller matrices: 64 ε times their norm; Lu and Chipman's factors: that over 1 − D²
and over the smallest depolarization factor, by both of which the decomposition divides.
"""

import sys

import fields_layers
import fields_matter
from common import Report
from evaluate import Program, check
from fields_shared import FALSIFIED, same_numbers_again

CHECKS = [
    fields_layers.interfaces_by_colour,
    fields_layers.interfaces_by_tmm,
    fields_layers.films_by_colour,
    fields_layers.films_by_tmm,
    fields_layers.plates_by_tmm,
    fields_layers.windows_by_tmm,
    fields_matter.elements,
    fields_matter.mueller_matrices,
    fields_matter.jones_parameters,
    fields_matter.decompositions,
    fields_matter.schell_beams,
]


def compare(program: Program) -> Report:
    """Run every check."""
    report = Report("Fields (largest difference in units of its bound; in brackets as it is)")
    same_numbers_again()
    for chapter in CHECKS:
        for row in chapter(program):
            what = f"{row.what}, {row.cases} cases [{row.largest:.1e}]"
            report.within(what, row.share, 1.0)
    return report


if __name__ == "__main__":
    sys.exit(check(__doc__, compare, FALSIFIED))
