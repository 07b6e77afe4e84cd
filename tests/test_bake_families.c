
int main(void)
{
    TEST(reversed_time_gives_the_reversed_curve);
    TEST(scaled_time_gives_the_scaled_curve);
    TEST(superposed_data_give_the_superposed_curve);
    TEST(every_family_solves_the_equation);
    TEST(coefficients_stay_near_the_amplitude);
    TEST(families_meet_at_their_borders);
    TEST(quadrature_equals_the_boundary_terms);
    return check_done();
}
