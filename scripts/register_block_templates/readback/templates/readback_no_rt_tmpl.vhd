-- Template that replaces the generator's own template for reads (see scripts/register_block.py). A read replaces every
-- word except the selected word by 0 and returns the OR of all words. Two registers hold this result: one register the
-- OR of the words with even numbers, the other register the OR of the words with odd numbers.
readback: block
    type words_t is array (natural range <>) of std_logic_vector({{cpuif.data_width-1}} downto 0);
    signal halves : words_t(0 to 1);
begin
    process(clk)
        variable words : words_t(0 to {{cpuif.word_count - 1}});
        variable chosen : words_t(0 to 1);
    begin
        if rising_edge(clk) then
            words := (others => (others => '0'));
            {{cpuif.words|indent(12)}}
            chosen := (others => (others => '0'));
            for word in words'range loop
                if s_cpuif_word(word) = '1' then
                    chosen(word mod 2) := chosen(word mod 2) or words(word);
                end if;
            end loop;
            halves <= chosen;
            readback_done <= decoded_req and not decoded_req_is_wr and not rst;
        end if;
    end process;
    readback_data <= halves(0) or halves(1);
    readback_err <= '0';
end block;
