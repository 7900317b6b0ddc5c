"""First columns of a mesh's row of slopes, common to one mesh stiffness and to pairs of teeth."""

# Arms of both toothing centres [m], direction of the line of centres, relative velocity of the toothing centres [m/s], absolute
# speeds of both rotors and rate of the mesh phase [rad/s].
LA_X, LA_Y, LB_X, LB_Y, S_E_X, S_E_Y, DV_X, DV_Y, SPIN_A, SPIN_B, S_PSI_RATE = range(11)
SHARED = 11
