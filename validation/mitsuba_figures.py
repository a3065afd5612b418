"""Two figures of Mitsuba's spectral variants, which the scripts of both Pythons need."""

import numpy as np

# luminance of the unit spectrum in the spectral variants
UNIT_LUMINANCE = 1.0010
# of linear sRGB
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
