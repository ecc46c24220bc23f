"""The quadrics of the entries of R, T, U = R^T T, T x R and T.T, by their names."""

import numpy as np

from gspcli.continuation.quadrics import FORMS
from gspcli.geometry import study

ROTATION, MOMENT = FORMS[np.array(study.ROTATION)], FORMS[np.array(study.MOMENT)]
TRANSLATION, BODY_TRANSLATION = FORMS[list(study.TRANSLATION)], FORMS[list(study.BODY)]
RHO = FORMS[study.RHO]
